for(;;){}
new Array(4294967295).forEach(function(){})
[].includes.call({length:9e15},1)
[].indexOf.call({length:9e15},1)
[].lastIndexOf.call({length:9e15},1)
/(a+)+$/.test('a'.repeat(40)+'b')
'x'.repeat(1<<30)
var a=[];for(var i=0;i<10000;i++)a=[a];JSON.stringify(a).length
var o={};for(var i=0;i<100000;i++)o=Object.create(o);o.zz
var p={};for(var i=0;i<100000;i++)p=new Proxy(p,{});p.zz
var s='x';for(;;)s+=s
new Array(4294967295).join('')
new Array(4294967295).join('x')
new Array(4294967295).fill(1)
new Array(4294967295).sort()
new Array(4294967295).reverse()
new Array(4294967295).indexOf(1)
new Array(4294967295).lastIndexOf(1)
new Array(4294967295).includes(1)
new Array(4294967295).slice(0).length
new Array(4294967295).concat([1]).length
new Array(4294967295).flat().length
new Array(4294967295).toString().length
new Array(4294967295).map(x=>x)
new Array(4294967295).some(x=>x)
new Array(4294967295).find(x=>x)
new Array(4294967295).findLast(x=>x)
new Array(4294967295).reduce((a,b)=>a,0)
new Array(4294967295).reduceRight((a,b)=>a,0)
new Array(4294967295).splice(0,4294967290).length
new Array(4294967295).shift()
new Array(4294967295).unshift(1)
new Array(4294967294).unshift(1)
new Array(4294967295).copyWithin(0,1)
new Array(4294967295).toReversed()
new Array(4294967295).toSorted()
new Array(4294967295).with(0,1)
[...new Array(4294967295)]
Array.from({length:4294967295})
Array.from(new Array(4294967295))
Math.max(...new Array(4294967295))
Array.from({length:9e15})
Array.prototype.splice.call({length:9e15},0,1)
Array.prototype.unshift.call({length:9e15-10},0,1)
Array.prototype.shift.call({length:9e15-10})
Array.prototype.reverse.call({length:9e15-10})
Array.prototype.fill.call({length:9e15-10},1)
Array.prototype.copyWithin.call({length:9e15-10},1,5)
Array.prototype.join.call({length:9e15-10},'')
Array.prototype.concat.call([],{length:9e15,[Symbol.isConcatSpreadable]:true})
[].flat.call({length:9e15})
[].sort.call({length:9e15})
[].slice.call({length:9e15})
[].every.call({length:9e15},x=>x)
[].toLocaleString.call({length:9e15})
[].toSpliced.call({length:9e15},0,1)
[].with.call({length:4294967295},0,1)
String.raw({raw:{length:9e15}})
JSON.stringify(new Array(4294967295)).length
JSON.stringify({a:new Proxy([],{get(t,k){return k=='length'?9e15:undefined}})})
var a=[];for(var i=0;i<50;i++)a=[a,a];a.flat(Infinity).length
var a=[];for(var i=0;i<50;i++)a=[a,a];a.join('')
var a=[];for(var i=0;i<50;i++)a=[a,a];String(a).length
var a=[];for(var i=0;i<50;i++)a=[a,a];JSON.stringify(a).length
var a={};for(var i=0;i<50;i++)a={x:a,y:a};JSON.stringify(a,(k,v)=>v)
var a={toJSON(){return undefined}};for(var i=0;i<50;i++)a={x:a,y:a};JSON.stringify(a)
new Set(new Array(4294967295).values())
new Set(new Array(4294967295))
new Array(4294967295).values().drop(4294967290).next()
new Array(4294967295).keys().drop(4294967290).next()
Iterator.from({next(){return {done:false}}}).drop(9e15).next()
(function*(){for(;;)yield 1})().drop(9e15).next()
(function*(){for(;;)yield 1})().toArray()
new Array(4294967295).values().toArray().length
Object.fromEntries(new Array(4294967295).fill)
Object.groupBy(new Array(4294967295).values(),x=>1)
Map.groupBy(new Array(4294967295).values(),x=>1)
Promise.all(new Array(4294967295).values())
'a'.repeat(4000000).indexOf('a'.repeat(2000000)+'b')
'a'.repeat(4000000).lastIndexOf('b'+'a'.repeat(2000000))
'a'.repeat(4000000).includes('a'.repeat(2000000)+'b')
'a'.repeat(2000000).split('a'.repeat(1000000)+'b').length
'a'.repeat(2000000).replaceAll('a'.repeat(1000000)+'b','').length
'a'.repeat(2000000).replace('a'.repeat(1000000)+'b','').length
'a'.repeat(4000000).split('').length
'a'.repeat(4000000).replaceAll('a','bbbbbbbbbbbbbbbbbbb').length
'a'.repeat(4000000).replaceAll('','bbbbbbbbbbbbbbbbbbb').length
'x'.padStart(1e9,'ab').length
'x'.padEnd(2**30-1,'ab').length
('\u0301\u0323'.repeat(400000)).normalize('NFD').length
('\u0301\u0323'.repeat(400000)).normalize('NFKC').length
('\u0301\u0323'.repeat(400000)).localeCompare('\u0323\u0301'.repeat(400000))
('\u0323\u0301'.repeat(4000)).localeCompare('\u0301\u0323'.repeat(4000))
'\ufdfa'.repeat(400000).normalize('NFKD').length
'ß'.repeat(4000000).toUpperCase().length
'İ'.repeat(2000000).toLowerCase().length
'Σ'.repeat(1000000).toLowerCase().length
(' '.repeat(1000000)+'Σ'+'\u00ad'.repeat(100000)).toLowerCase().length
('Σ'+'\u00ad'.repeat(3000)).repeat(300).toLowerCase().length
('\u00ad'.repeat(3000)+'Σ').repeat(300).toLowerCase().length
'Σ\u00ad'.repeat(200000).toLowerCase().length
parseInt('9'.repeat(4000000))
parseFloat('9'.repeat(4000000))
+('9'.repeat(4000000)+'.5e-5')
Number('0x'+'f'.repeat(4000000))
Number('0.'+'0'.repeat(4000000)+'1')
2n**100000000n
(1n<<1000000000n)
var a=3n;for(;;)a=a*a
var a=10n;for(var i=0;i<17;i++)a=a*a;a.toString().length
BigInt('9'.repeat(300000))
BigInt('9'.repeat(3000000))
BigInt('0x'+'f'.repeat(250000)).toString().length
BigInt.asUintN(1000000000,-1n)
new Uint8Array(1e9)
new Uint8Array(10e6).sort()[0]
new Float64Array(1e6).map((x,i)=>-i).sort()[0]
new Uint8Array(10e6).indexOf(3)
new Uint8Array(4e6).join('').length
new ArrayBuffer(8,{maxByteLength:1e9})
new ArrayBuffer(1e9)
var a=[];a[4294967294]=1;a.length=0;a.length
var a=[];a[4294967294]=1;a.sort();a.length
var a=[];a[4294967294]=1;a.push(1)
var a=[];a[4294967294]=1;Object.keys(a).length
var a=[];a[4294967294]=1;Object.freeze(a);a.length=5
new RegExp('(((a{1000}){1000}){1000}){1000}').test('a')
new RegExp('((((a?){1000}){1000}){1000}){1000}b').test('a'.repeat(1000))
new RegExp('('.repeat(100000))
new RegExp('('.repeat(100000)+')'.repeat(100000))
new RegExp('(?:'.repeat(3000)+')'.repeat(3000)).test('')
new RegExp('a?'.repeat(3000)+'a'.repeat(3000)).test('a'.repeat(3000))
var s='[';for(var i=0;i<65000;i+=2)s+='\\u'+i.toString(16).padStart(4,'0');new RegExp(s+']').test('a')
var s='[';for(var i=0;i<65000;i+=2)s+='\\u'+i.toString(16).padStart(4,'0');new RegExp(s+']','iu').test('a')
new RegExp('[^a]'.repeat(50000),'iu').test('a')
new RegExp('\\p{L}'.repeat(20000),'iu').test('a')
new RegExp('[\\p{L}--\\p{Lu}]'.repeat(2000),'iv').test('a')
new RegExp('\\W'.repeat(20000),'iu').test('a')
var s='';for(var i=0;i<20000;i++)s+='(?<a'+i+'>x)';new RegExp(s).test('x')
var s='';for(var i=0;i<250;i++)s+='(?<a'+i+'>x)';new RegExp(s).exec('x'.repeat(250)).groups.a9
'a'.repeat(4000000).replace(/a/g,'').length
'a'.repeat(4000000).match(/a/g).length
'a'.repeat(4000000).split(/a/).length
'ab'.repeat(100000).replace(/a(?=(?:.|.){0,500}c|)/g,'').length
'ab'.repeat(100000).match(/(?:a|ab)(?=(?:.){0,2000}c|)/g).length
[...'ab'.repeat(100000).matchAll(/a(?=(?:.|.){0,500}c|)/g)].length
'x'.repeat(1000000).search(/(x+x+)+y/)
/(?=(a+))a*b\1/.test('a'.repeat(100000))
/^(([a-z])+.)+[A-Z]([a-z])+$/.test('a'.repeat(1000))
/(.*)(.*)(.*)(.*)(.*)[^b]$/.exec('b'.repeat(10000))
/(?<=(a+)+)b/.test('a'.repeat(50)+'c')
var f=()=>f();f()
var f=()=>{try{f()}catch(e){f()}};f()
var f=()=>{try{f()}finally{f()}};f()
var f=function(){return [1].map(f)};f()
var f=function(){return JSON.stringify({toJSON:f})};f()
var f=function(){return 'a'.replace(/a/,f)};f()
var f=function(){return [2,1].sort(f)};f()
var o={get x(){return this.x}};o.x
var o={toString(){return ''+this}};''+o
var o={valueOf(){return +this}};+o
var p=new Proxy({},{get(t,k,r){return r[k]}});p.x
var f=function(){return new f()};new f()
class A{constructor(){new A()}};new A()
function*g(){yield*g()};[...g()]
var f=()=>eval('f()');f()
var f=Function.prototype.call;f=f.bind(f);for(var i=0;i<100000;i++)f=f.bind(f);f()
var f=()=>1;for(var i=0;i<30000;i++)f=f.bind(null);f()
var a=[];for(var i=0;i<100000;i++)a=[a];a.flat(Infinity)
var a=[];for(var i=0;i<100000;i++)a=[a];String(a)
JSON.parse('['.repeat(100000))
JSON.parse('['.repeat(1000000)+']'.repeat(1000000))
JSON.parse('{"a":'.repeat(100000))
JSON.parse('['+'1,'.repeat(1000000)+'1]').length
var o={};o.o=o;JSON.stringify(o)
var a=[];for(var i=0;i<100000;i++)a={a};a=null;1
var a=[];a[0]=a;a.toString()
var a=[];a[0]=a;a.flat(Infinity)
var x={};for(var i=0;;i++)x['k'+i]=i
var x=[];for(;;)x.push(x)
var x=new Map;for(var i=0;;i++)x.set(i,i)
var x=new Set;for(var i=0;;i++)x.add({})
var x=[];for(;;)x=[x,x]
var x;for(;;)x={x}
var x='';for(;;)x+='abc'+x.length
var x=[];for(;;)x.push('a'.repeat(1000)+x.length)
for(;;)Promise.resolve().then(()=>1)
for(;;)new Promise(()=>{})
(async function f(){await f()})()
var f=async()=>{for(;;)await 1};f()
var s=Symbol();for(;;)Symbol.for('a'+Math.random())
for(var i=0;;i++)Symbol('x'.repeat(1000)+i)
class A{static{for(;;);}}
label:for(;;){continue label}
do{}while(true)
while(true)try{throw 1}catch{}
while(true)try{null.x}catch{}
for(var i=0;i<1e6;i++)try{throw new Error('x')}catch{}
for(;;)try{f()}catch{};function f(){f()}
for(;;)try{'x'.repeat(1e9)}catch{}
for(;;)try{new Array(1e9).fill(0)}catch{}
for(;;)try{JSON.parse('[')}catch{}
for(;;)new RegExp('a{1,100}'.repeat(100))
for(;;)new Date().toString()
for(;;)[3,2,1].sort()
for(;;)'abc'.split('')
var a=Array.from({length:100000},(x,i)=>-i);for(;;)a.slice().sort((x,y)=>x-y)
var a=Array.from({length:100000},(x,i)=>-i);for(;;)[...a]
var a=Array.from({length:100000},(x,i)=>-i);for(;;)a.shift()
var a=[];for(;;)a.unshift(1)
var o={};for(var i=0;i<30000;i++)o['k'+i]=i;for(;;)({...o})
var o={};for(var i=0;i<30000;i++)o['k'+i]=i;for(;;)Object.keys(o)
var s='x'.repeat(3e6);for(;;)s===(s+'x')
var s='x'.repeat(3e6);for(;;)s.toUpperCase()
var s='1'.repeat(3e6);for(;;)+s
var o={};for(var i=0;i<30000;i++)o=Object.create(o);for(;;)o.zzz
var o={};for(var i=0;i<30000;i++)o=Object.create(o);for(;;)'zzz' in o
var s='';for(var i=0;i<20000;i++)s='x'+s+'y';for(;;)s=s.slice(1)+'z'
String.fromCharCode.apply(null,new Array(65000).fill(97)).length
String.fromCharCode.apply(null,new Array(650000))
Math.max.apply(null,{length:4294967295})
Reflect.apply(Math.max,null,{length:1e9})
Reflect.construct(Array,{length:1e9})
(function(){return arguments.length})(...new Array(100000).fill(1))
Object.defineProperty([],'length',{value:4294967295}).map(x=>x)
Array.prototype.push.apply([],{length:65000}).length
Array.prototype.push.call({length:2**53-2},1)
[].entries().drop(1)
Atomics.wait(new Int32Array(new SharedArrayBuffer(4)),0,0)
new Function('for(;;);')()
(async()=>{}).constructor('for(;;);')()
import('x')
debugger;for(;;);
Error.stackTraceLimit=1e9;var f=n=>n?f(n-1):new Error().stack.length;f(500)
Error.prepareStackTrace=()=>{throw 1};null.x
Error.prepareStackTrace=(e,s)=>f();function f(){null.x};f()
structuredClone([])
new WeakRef({}).deref()
new FinalizationRegistry(()=>{}).register({},1)
queueMicrotask(()=>{for(;;);})
performance.now()
new Intl.NumberFormat()
(1234.5).toLocaleString()
var o={};for(var i=0;i<500;i++)o['k'+i]=i;for(;;)for(var k in o)break
var o={};for(var i=0;i<300;i++)o['k'+i]=i;for(;;)for(var k in o)break
for(var a=[];;)a=[...a,1]
for(var a=[];;)a=a.concat([1])
for(var s='';;)s=s+'x',s[0]
var a=[];for(;;){a.push({});a.length>9000&&(a=[])}
var x=[];for(;;)x.push(()=>x)
for(;;)new Map()
for(;;)(()=>{var a={};a.a=a})()
return new RegExp('((((a?){100}){100}){100}){10}b').test('a'.repeat(10))
return new RegExp('(?:(?:(?:(?:){100}){100}){100}){10}b').test('aa')
return new RegExp('(?:(?:(?:(?:a?){100}){100}){100}){10}b').test('aa')
return new RegExp('((((){100}){100}){100}){10}b').test('aa')
var o={};for(var i=0;i<50;i++)o['k'+i]=i;for(;;)({...o})
var o={};for(var i=0;i<500;i++)o=Object.create(o);for(;;)o.zzz
x = a()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()()
return `${2**3}`
