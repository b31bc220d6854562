// Small helpers for elements. Texts become text nodes, so nothing that a user names can be markup.

export const $ = id => document.getElementById(id);

export function element(name, properties = {}, ...children) {
  const made = document.createElement(name);
  Object.assign(made, properties);
  made.append(...children);
  return made;
}

const SVG = 'http://www.w3.org/2000/svg';

export function shape(name, attributes = {}, ...children) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

// What the server has drawn: its texts are escaped there, and the page's policy lets no script of it run.
export function drawn(place, markup) {
  // What is drawn again would lose the focus, and be scrolled back.
  if (place.firstChild && place.markup === markup) return;
  place.markup = markup;
  place.innerHTML = markup;
}

let hiding;

// Tells the user something for a while.
export function notice(words, lasting = false) {
  const place = $('notice');
  place.textContent = words;
  place.hidden = !words;
  clearTimeout(hiding);
  if (!lasting) hiding = setTimeout(() => { place.hidden = true; }, 8000);
}
