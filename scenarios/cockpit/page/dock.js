// The panels of a wide page fill the window. A line between two of them moves with the pointer or the arrow keys; each
// panel can be hidden. Both are kept in a cookie: each run may have another port, and a browser keeps other things per
// port. On a narrow page, the panels are below each other.

import { $, element } from './dom.js';

const KEPT = 'steward-panels';
const LEAST = 8;

const panels = [...document.querySelectorAll('[data-panel]')];
const boxes = [...document.querySelectorAll('[data-share]')];
const name = box => box.id || [...box.querySelectorAll('[id]')].find(({ dataset }) => dataset.panel).id + '-box';
const shares = new Map(boxes.map(box => [box, Number(box.dataset.share)]));
const hidden = new Set();

export function dock() {
  recall();
  for (const box of boxes) if (box.previousElementSibling) box.before(line(box));
  $('panels').lastElementChild.replaceChildren(...panels.map(choice), reset());
  arrange();
}

function choice(panel) {
  const box = element('input', { type: 'checkbox', checked: !hidden.has(panel) });
  box.onchange = () => {
    if (box.checked) hidden.delete(panel);
    else hidden.add(panel);
    keep();
  };
  return element('label', {}, box, panel.dataset.panel);
}

function reset() {
  const button = element('button', { type: 'button', textContent: 'As at first' });
  button.onclick = () => {
    boxes.forEach(box => shares.set(box, Number(box.dataset.share)));
    hidden.clear();
    $('panels').querySelectorAll('input').forEach(input => { input.checked = true; });
    keep();
  };
  return button;
}

// Whether a box or one of the panels in it is shown. Others hide a panel that has nothing to show.
const shown = box => [box, ...box.querySelectorAll('[data-panel]')].some(panel =>
  panel.dataset.panel && !hidden.has(panel) && !panel.hidden && getComputedStyle(panel).display !== 'none');

export function arrange() {
  for (const panel of panels) panel.classList.toggle('away', hidden.has(panel));
  for (const box of boxes) {
    box.style.setProperty('--share', shares.get(box));
    if (!box.dataset.panel) box.classList.toggle('away', !shown(box));
    if (box.splits) box.splits.hidden = !shown(box) || !before(box);
  }
}

// The next box before this one that is shown.
function before(box) {
  const others = boxes.filter(other => other.parentElement === box.parentElement);
  return others.slice(0, others.indexOf(box)).findLast(shown);
}

// The line between a box and the one before it.
function line(box) {
  const across = box.parentElement.matches('.row');
  const between = `${box.dataset.panel ?? 'the panels below'}: size`;
  const handle = element('div', { className: 'line', tabIndex: 0, role: 'separator', ariaLabel: between,
                                  ariaOrientation: across ? 'vertical' : 'horizontal' });
  box.splits = handle;
  const size = other => other.getBoundingClientRect()[across ? 'width' : 'height'];
  // Moves it by pixels.
  const move = by => {
    const other = before(box);
    const [sum, length] = [shares.get(other) + shares.get(box), size(other) + size(box)];
    const share = Math.min(Math.max(shares.get(other) + by / length * sum, sum * LEAST / 100), sum * (1 - LEAST / 100));
    shares.set(other, share);
    shares.set(box, sum - share);
    handle.ariaValueNow = Math.round(100 * share / sum);
    keep();
  };
  handle.ariaValueNow = 50;
  handle.onpointerdown = event => handle.setPointerCapture(event.pointerId);
  handle.onpointermove = event => {
    if (handle.hasPointerCapture(event.pointerId)) move(across ? event.movementX : event.movementY);
  };
  handle.onkeydown = event => {
    const step = { ArrowLeft: -24, ArrowUp: -24, ArrowRight: 24, ArrowDown: 24 }[event.key];
    if (!step) return;
    event.preventDefault();
    move(step);
  };
  return handle;
}

function keep() {
  arrange();
  const sizes = Object.fromEntries([...shares].map(([box, share]) => [name(box), Math.round(share * 10) / 10]));
  const kept = encodeURIComponent(JSON.stringify({ sizes, hidden: [...hidden].map(({ id }) => id) }));
  document.cookie = `${KEPT}=${kept}; SameSite=Strict; Max-Age=31536000`;
}

function recall() {
  const cookie = document.cookie.split('; ').find(cookie => cookie.startsWith(`${KEPT}=`));
  let kept = null;
  try { kept = JSON.parse(decodeURIComponent(cookie?.slice(KEPT.length + 1) ?? 'null')); } catch { /* Not ours. */ }
  for (const box of boxes) {
    const share = kept?.sizes?.[name(box)];
    if (share > 0 && share < 100) shares.set(box, share);
  }
  panels.filter(({ id }) => kept?.hidden?.includes?.(id)).forEach(panel => hidden.add(panel));
}
