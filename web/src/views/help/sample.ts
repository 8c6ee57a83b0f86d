// One click makes a small job of the bundled sample and goes to it.
import {api, ask, randomKey} from '../../api/client';
import {el, replace} from '../../dom';
import {icon} from '../../parts/icon';
import {problemBox} from '../../parts/problem';
import {toJob} from '../../route';
import {announce} from '../../state';
import {t} from '../../text';

// Coarse, so that the result is there in some seconds.
const settings = {
  sheet: {resolution_mm: 4}, print: {dpi: 150}, scan: {front: '+y', left_side: 'minus_x'},
  coils: {decouple: true, build: 'bridges', gaps: 4},
};

async function make(key: string): Promise<string> {
  const form = new FormData();
  const files = [['scan', 'head.stl'], ['pattern', 'pattern.svg']] as const;
  const contents = await Promise.all(files.map(async ([, file]) => (await ask(`/sample/${file}`)).blob()));
  files.forEach(([input, file], i) => form.append(input, contents[i] ?? new Blob(), file));
  form.append('settings', JSON.stringify(settings));
  form.append('reference', t('help.sample_reference'));
  return (await api.create(form, key)).id;
}

export function sampleButton(): HTMLElement {
  const key = randomKey();  // of this button: two clicks make one job
  const problem = el('div');
  const start = async (): Promise<void> => {
    button.disabled = true;
    announce(t('help.sample_starts'));
    try {
      location.hash = toJob(await make(key));
    } catch (error) {
      replace(problem, problemBox(error, () => void start()));
    } finally {
      button.disabled = false;
    }
  };
  const button = el('button', {type: 'button', class: 'primary', onclick: () => void start()}, icon('resume'), t('help.sample'));
  return el('div', {class: 'sample'}, problem, el('p', {class: 'row'}, button, el('span', {class: 'quiet'}, t('help.sample_hint'))));
}
