// Small helpers for elements. Texts become text nodes, so a name that a user chose cannot become markup.

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

// Shows what the server has drawn. The server escapes its texts, and the page's policy lets no script in it run.
export function drawn(place, markup) {
  // Drawing it again would lose the focus and the scroll position.
  if (place.firstChild && place.markup === markup) return;
  place.markup = markup;
  place.innerHTML = markup;
}

let hiding;

// Hides this message if it is still shown.
export function retract(words) {
  if (words && $('notice').textContent === words) notice('');
}

// Shows the user a message for a while.
export function notice(words, lasting = false) {
  const place = $('notice');
  place.textContent = words;
  place.hidden = !words;
  clearTimeout(hiding);
  if (!lasting) hiding = setTimeout(() => { place.hidden = true; }, 8000);
}
