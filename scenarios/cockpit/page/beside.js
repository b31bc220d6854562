// Several runs side by side: each has its own page inside this one, which has one slider for all of them.

import { $, element } from './dom.js';

export function beside(count) {
  const pages = Array.from({ length: count }, (_, side) => {
    const address = new URL(location.href);
    address.searchParams.set('side', side);
    const page = element('iframe', { src: address.href, title: `Run ${side + 1}` });
    page.onload = () => join(page);
    return page;
  });
  // The page scrolls over the inner pages.
  document.body.classList.remove('docked');
  const main = document.querySelector('main');
  main.hidden = true;
  main.after(element('div', { className: 'beside' }, ...pages));
}

// An inner page is as high as its content, and passes its keys to the outer page. Its landmarks say whose they are.
function join(page) {
  const inside = page.contentDocument;
  for (const part of inside.querySelectorAll('header, main, section')) {
    part.ariaLabel = part.ariaLabel ? `${page.title}: ${part.ariaLabel}` : page.title;
  }
  new ResizeObserver(() => { page.style.height = `${inside.documentElement.offsetHeight}px`; }).observe(inside.body);
  inside.addEventListener('keydown', ({ key, target }) => {
    if (target.closest('input, select, textarea, button, summary')) return;
    document.body.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
  });
}

// How the runs are aligned, and where they first differ.
export class Comparison {
  constructor(link, transport) {
    this.place = $('beside');
    [this.aligns, this.words] = [$('aligns'), $('compared')];
    this.aligns.onchange = () => link.ask('align', { on: this.aligns.checked });
    // The slider has steps.
    $('differ').onclick = () => transport.go(Math.ceil(this.differs * 50) / 50);
  }

  show({ can_align: canAlign, aligns, words, difference_s: differs }) {
    this.place.hidden = false;
    this.aligns.parentElement.hidden = !canAlign;
    this.aligns.checked = aligns;
    this.words.textContent = words;
    this.differs = differs;
    $('differ').hidden = differs == null;
  }
}
