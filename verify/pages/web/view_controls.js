'use strict';
// Controls of parameters, made from the table that the program sends; and the numbers of a frame.

const byId = (id) => document.getElementById(id);

function fillSelect(select, words) {
  select.replaceChildren(...words.map((word) => element('option', { value: word, textContent: word })));
}

// One control for a row of the table; change(value) is called with a text.
function parameterControl(info, change) {
  const id = `parameter-${info.name}`;
  let control;
  if (info.words || info.only) {
    control = element('select', { id });
    fillSelect(control, (info.words ?? info.only).map(String));
  } else {
    control = element('input', { id, type: 'number', min: info.low, max: info.high, step: info.multiple_of });
  }
  control.title = `${info.help} (${info.valid})`;
  control.addEventListener('change', () => { if (control.checkValidity()) change(control.value); });
  return [element('label', { htmlFor: id, textContent: info.title, title: control.title }), control];
}

class Controls {
  constructor(send) {
    this.send = send;
    this.parameters = new Map();
    const shows = (id, name, value) => byId(id).addEventListener('change', () => { if (byId(id).checkValidity()) send({ type: 'show', [name]: value(byId(id)) }); });
    shows('what', 'what', (e) => e.value);
    shows('tone', 'tone', (e) => e.value);
    shows('exposure', 'exposure', (e) => Number(e.value));
    shows('filtered', 'filtered', (e) => e.checked);
    shows('measured', 'measured', (e) => e.checked);
    for (const name of ['backend', 'moving_samples']) byId(name).addEventListener('change', () => { if (byId(name).checkValidity()) this.set({ [name]: byId(name).value }); });
    byId('size').addEventListener('change', () => {
      const found = byId('size').value.match(/^(\d+)x(\d+)$/);
      if (found) this.set({ image_width: found[1], image_height: found[2] });
    });
  }

  set(values) { this.send({ type: 'set', values }); }

  hello(message) {
    fillSelect(byId('backend'), message.backends);
    fillSelect(byId('compare-backend'), message.backends);
    fillSelect(byId('what'), message.subjects);
    fillSelect(byId('tone'), message.tones);
    this.cannot = message.cannot;
    for (const info of message.parameters) {
      if (this.parameters.has(info.name) || info.name.startsWith('image_')) continue;
      const [label, control] = parameterControl(info, (value) => this.set({ [info.name]: value }));
      this.parameters.set(info.name, control);
      byId('parameters').append(label, control);
    }
  }

  state(message) {
    const put = (control, value) => { if (document.activeElement !== control || control.type === 'checkbox') control.value = value; };
    for (const [name, control] of this.parameters) put(control, message.parameters[name]);
    put(byId('backend'), message.backend);
    byId('backend').value = message.backend;
    put(byId('size'), `${message.parameters.image_width}x${message.parameters.image_height}`);
    put(byId('moving_samples'), message.moving_samples);
    byId('what').value = message.what;
    byId('tone').value = message.tone;
    put(byId('exposure'), message.exposure);
    byId('filtered').checked = message.filtered;
    byId('measured').checked = message.measured;
    const why = this.cannot?.[message.backend] ?? '';
    byId('cannot').hidden = !why;
    byId('cannot').textContent = why;
    const stages = ['distance', 'primitive', 'normal', 'queues', 'bounces'];
    for (const option of byId('what').options) option.disabled = Boolean(why) && stages.includes(option.value);
    byId('verify-start').disabled = Boolean(why);
    byId('queues-start').disabled = Boolean(why);
    byId('command').replaceChildren(command(message.command, 'render this view'));
    byId('save-note').textContent = message.camera_file
      ? 'The picture at rest, without filter. The command that renders it, with the camera’s file in the same folder:'
      : 'The picture at rest, without filter. The command that renders it:';
  }

  changed(message) {
    const list = byId('changed');
    if (list.querySelector('.quiet')) list.replaceChildren();
    list.prepend(element('li', { textContent: message.text, className: message.fault ? 'fault' : '' }));
    while (list.children.length > 20) list.lastChild.remove();
  }
}

const rate = (value) => {
  if (!(value > 0)) return '–';
  for (const [size_, letter] of [[1e9, 'G'], [1e6, 'M'], [1e3, 'k']]) if (value >= size_) return `${(value / size_).toPrecision(3)} ${letter}`;
  return value.toPrecision(3);
};
const milliseconds = (seconds) => (1e3 * seconds).toFixed(seconds < 0.01 ? 2 : 1);

function fillTable(table, rows) {
  table.tBodies[0].replaceChildren(...rows.map((row) => element('tr', {}, ...row.map((cell, i) => element(i === 0 ? 'th' : 'td', i === 0 ? { scope: 'row', textContent: cell } : { textContent: cell })))));
}

// What a frame says of itself, in one line.
function frameText(header, framesPerSecond, latency) {
  const text = [`${header.samples} of ${header.target} samples`, `${header.width}x${header.height}${header.rest ? '' : ` of ${header.full.join('x')}`}`];
  if (header.noise > 0) text.push(`noise ${(100 * header.noise).toPrecision(3)} %`);
  if (header.filter !== 'none') text.push(`${header.filter} filter`);
  if (framesPerSecond > 0) text.push(`${framesPerSecond.toFixed(1)} frames/s`);
  if (latency > 0) text.push(`${latency.toFixed(0)} ms from input`);
  if (header.hash) text.push(`bits ${header.hash}`);
  return text.join(' · ');
}

function showNumbers(header) {
  const { rays, stages, levels } = header.statistics ?? {};
  const seconds = header.statistics?.seconds ?? header.render_seconds;
  const rows = [['samples/s', `${rate(header.samples_per_second)}`], ['render', `${milliseconds(header.render_seconds)} ms`], ['encoding', `${milliseconds(header.encode_seconds)} ms`]];
  if (rays) {
    for (const kind of ['primary', 'bounce', 'shadow']) if (rays[kind] > 0) rows.push([`${kind} rays/s`, rate(rays[kind] / seconds)]);
    const launched = stages.reduce((sum, [, s]) => sum + s, 0);
    if (launched > 0 && launched < seconds) rows.push(['between launches, and transfer', `${milliseconds(seconds - launched)} ms`]);
  }
  if (header.device_bytes > 0) rows.push(['buffers', `${(header.device_bytes / 1e6).toFixed(1)} MB`]);
  fillTable(byId('numbers'), rows);
  if (!stages?.length) return;
  const time = (s) => s > 0 ? milliseconds(s) : '–';
  fillTable(byId('stages'), [...stages.map(([label, s, launches]) => [label, time(s), String(launches)]),
    ...levels.map(([level, s]) => [`traversal, level ${level}`, time(s), ''])]);
}
