// Several runs side by side: each in a page of its own inside this one, which has the slider for all of them.

import { element } from './dom.js';

export function beside(count) {
  const pages = Array.from({ length: count }, (_, side) => {
    const address = new URL(location.href);
    address.searchParams.set('side', side);
    const page = element('iframe', { src: address.href, title: `Run ${side + 1}` });
    page.onload = () => join(page);
    return page;
  });
  const main = document.querySelector('main');
  main.hidden = true;
  main.after(element('main', { className: 'beside' }, ...pages));
}

// A page inside is as high as what it shows, and its keys are keys of the whole.
function join(page) {
  const inside = page.contentDocument;
  new ResizeObserver(() => { page.style.height = `${inside.documentElement.offsetHeight}px`; }).observe(inside.body);
  inside.addEventListener('keydown', ({ key, target }) => {
    if (target.closest('input, select, textarea, button, summary')) return;
    document.body.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
  });
}
