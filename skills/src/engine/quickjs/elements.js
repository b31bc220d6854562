// XML data as objects: the part of the DOM that is read. `describe` gives {name, attributes, children, source}.
(function () {
  'use strict';
  class Text {
    constructor(text) {
      this.nodeType = 3;
      this.nodeName = '#text';
      this.nodeValue = this.data = this.textContent = text;
    }
    toString() { return this.data; }
  }
  class Element {
    #attributes;
    constructor(description) {
      this.nodeType = 1;
      this.nodeName = this.tagName = this.localName = description.name;
      this.namespaceURI = description.namespace;
      this.#attributes = description.attributes;
      this.childNodes = description.children.map((child) => typeof child === 'string' ? new Text(child) : new Element(child));
      Object.defineProperty(this, 'outerXML', { value: description.source });
      Object.freeze(this.childNodes);
      Object.freeze(this);
    }
    get documentElement() { return this; }
    get children() { return this.childNodes.filter((node) => node.nodeType === 1); }
    get firstChild() { return this.childNodes[0] ?? null; }
    get lastChild() { return this.childNodes[this.childNodes.length - 1] ?? null; }
    get textContent() { return this.childNodes.map((node) => node.textContent).join(''); }
    hasAttribute(name) { return Object.hasOwn(this.#attributes, name); }
    getAttribute(name) { return this.hasAttribute(name) ? this.#attributes[name] : null; }
    getElementsByTagName(name) {
      return this.children.flatMap((child) => {
        const inside = child.getElementsByTagName(name);
        return name === '*' || child.tagName === name ? [child, ...inside] : inside;
      });
    }
    toString() { return this.outerXML; }
  }
  for (const part of [Text, Element]) {
    Object.freeze(part);
    Object.freeze(part.prototype);
  }
  return (description) => new Element(description);
})()
