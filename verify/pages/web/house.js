'use strict';
// Shared by all pages: making elements, commands to copy, and a state that lives in the address.

// Text is only inserted as text: nothing that comes from a file becomes markup.
function element(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in made) made[name] = value;
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

function command(text, what) {
  return element('div', { className: 'command' }, element('code', { textContent: text }),
    element('button', { type: 'button', className: 'copy', textContent: 'Copy', 'aria-label': `Copy the command to ${what}` }));
}

// Older browsers keep the clipboard from pages opened from disk; there the command is selected and copied the old way.
function copyCommand(button) {
  const code = button.parentElement.querySelector('code');
  const done = () => {
    button.textContent = 'Copied';
    setTimeout(() => { button.textContent = 'Copy'; }, 1500);
  };
  const byHand = () => {
    getSelection().selectAllChildren(code);
    if (document.execCommand('copy')) done();
  };
  if (navigator.clipboard) navigator.clipboard.writeText(code.textContent).then(done, byHand);
  else byHand();
}

document.addEventListener('click', (event) => {
  const button = event.target.closest('button.copy');
  if (button) copyCommand(button);
});

// Turns the address's #a=1&b=2 into an object, and back. Looking around adds no "back" steps, unless asked for.
function stateFromAddress() {
  return Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
}

function stateToAddress(state, trail = false) {
  const kept = Object.entries(state).filter(([, value]) => value !== undefined && value !== '');
  const address = `#${String(new URLSearchParams(kept)).replaceAll('%2C', ',')}`;
  if (trail) history.pushState(null, '', address);
  else history.replaceState(null, '', address);
}
