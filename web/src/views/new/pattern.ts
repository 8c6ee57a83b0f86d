// Section 2: a drawing of the person, or an array of coils that the service makes for the scan.
import {el, replace, type Children} from '../../dom';
import {Problem} from '../../api/client';
import type {SettingsSchema} from '../../api/types';
import {dropZone} from '../../parts/drop-zone';
import {icon} from '../../parts/icon';
import {problemBox} from '../../parts/problem';
import {svgWithSize} from '../../read/drawing';
import {toJob} from '../../route';
import {choiceOf} from '../../parts/words';
import {drawnSize, hasScan, printsScan, settingOf, valueOf, type DraftState, type Pattern} from '../../state/draft';
import {bytes, number, percent, t} from '../../text';
import {follow, live, onEnd} from '../../view';
import {draftFields} from './fields';
import {transferLine} from './transfer';
import {cancelLayout, draft, keptFile, layout, makeLayout, onSideJob, removePattern, setSetting, takePattern} from './work';

export const patternTypes = ['.svg', '.svgz', '.dxf', '.png', '.jpg', '.jpeg', '.zip'] as const;
const placed = ['pattern.inked_face', 'pattern.width_mm', 'pattern.dpi', 'pattern.line_mm', 'pattern.rotate_deg', 'pattern.scale', 'pattern.offset_mm'];
const built = ['coils.build', 'coils.gaps'];
const arranged = ['layout.count', 'layout.diameter_mm', 'layout.region', 'layout.overlap'];

export function sizeText(size: readonly [number, number]): string {
  const [width, height] = size.map((mm) => number(Number(mm.toFixed(1))));
  return Number.isNaN(size[1]) ? t('new.size_width', {width: width ?? ''}) : t('new.size', {width: width ?? '', height: height ?? ''});
}

// Loads the drawing into the image. False if this page does not have it.
export async function loadDrawing(pattern: Pattern, image: HTMLImageElement): Promise<boolean> {
  const blob = keptFile(pattern.mark);
  if (!blob) return false;
  image.src = URL.createObjectURL(pattern.kind === 'svg' ? new Blob([svgWithSize(await blob.text())], {type: blob.type}) : blob);
  await image.decode().catch(() => {});  // the service says what is wrong with it
  URL.revokeObjectURL(image.src);
  return image.naturalWidth > 0;
}
function picture(pattern: Pattern, alt: string): Children {
  if (pattern.kind === 'other') return el('p', {class: 'quiet'}, t('new.drawing_unseen'));
  if (!keptFile(pattern.mark)) return el('p', {class: 'quiet'}, t('new.no_picture'));
  const image = el('img', {alt, class: 'flat', width: 480, height: Math.round(480 / (pattern.aspect ?? 1))});
  void loadDrawing(pattern, image);
  return el('div', {class: 'paper'}, image);
}

// Which unit was taken, and why.
function sizeFrom(pattern: Pattern, {schema, form}: DraftState): string {
  const given = (id: string): number | null => {
    const value = schema && valueOf(schema, form.settings, id);
    return typeof value === 'number' ? value : null;
  };
  const dpi = given('pattern.dpi');
  if (given('pattern.width_mm') !== null) return t('new.size_by_width');
  if (dpi !== null && pattern.px) return t('new.size_by_dpi', {dpi: number(dpi)});
  return pattern.dpi ? t('new.size_by_program', {program: pattern.program ?? '', dpi: number(pattern.dpi)}) : t('new.size_by_file');
}

function chosen(now: DraftState): Children {
  const {pattern} = now.form;
  if (!pattern) {
    return now.from?.pattern && el('p', {class: 'notice good'}, icon('check'), t('new.pattern_of_job', {
      extension: now.from.pattern.extension.toUpperCase(), bytes: bytes(now.from.pattern.bytes)}));
  }
  const size = drawnSize(pattern, now);
  const words = size ? sizeText(size) : '';
  return el('figure', {class: 'pattern-figure'},
    picture(pattern, t('new.pattern_alt', {name: pattern.name, size: words})),
    el('figcaption', null,
      el('p', null, el('strong', {class: 'file-name'}, pattern.layout ? t('new.pattern_made') : pattern.name), ' ',
        el('span', {class: 'quiet'}, bytes(pattern.bytes))),
      size ? el('p', {class: 'big-figure'}, words)
           : pattern.kind !== 'other' && el('p', {class: 'notice'}, icon('warning'), t('new.no_size')),
      size && el('p', {class: 'quiet small', id: 'size-from'}, sizeFrom(pattern, now)),
      el('p', {class: 'quiet small'}, t('new.size_hint')),
      el('p', null, el('button', {type: 'button', id: 'pattern-remove', class: 'plain', onclick: removePattern}, icon('delete'), t('new.remove_pattern')))));
}

function layoutProgress(): HTMLElement {
  const host = el('div', null);
  const show = (): void => {
    const {job, problem} = layout.now;
    replace(host, problem ? problemBox(problem, () => void makeLayout())
      : !job ? null
      : job.problem ? problemBox(new Problem(job.problem), () => void makeLayout())
      : job.state === 'succeeded' ? [
          (draft().form.pattern?.offHead ?? 0) > 0 && el('p', {class: 'notice', role: 'alert'}, icon('warning'),
            el('span', null, t('new.layout_off_head', {count: draft().form.pattern?.offHead ?? 0}))),
          el('p', {class: 'row'}, icon('check'), t('new.layout_done'), el('a', {href: toJob(job.id)}, t('new.layout_figures')))]
      : job.state === 'cancelled' ? null
      : el('div', {class: 'transfer'},
          el('p', {class: 'spread'}, el('strong', null, t('new.layout_running')), el('span', {class: 'number'}, percent(job.progress))),
          el('progress', {max: 1, value: job.progress, 'aria-label': t('new.layout_running')}),
          el('p', null, el('button', {type: 'button', id: 'layout-cancel', onclick: () => void cancelLayout()}, icon('cancel'), t('new.layout_cancel')))));
  };
  show();
  onEnd(onSideJob(show));
  return host;
}

function arrange(schema: SettingsSchema): Children {
  const button = el('button', {type: 'button', class: 'make', id: 'make-layout', onclick: () => {
    if (button.getAttribute('aria-disabled') !== 'true') void makeLayout();
  }}, icon('pattern'), t('new.make_layout'));
  const why = el('p', {class: 'quiet small', id: 'layout-why'}, t('new.layout_needs_scan'));
  button.setAttribute('aria-describedby', why.id);
  follow((state) => hasScan(state.draft) && !state.draft.layout, (may) => {
    if (may) button.removeAttribute('aria-disabled');
    else button.setAttribute('aria-disabled', 'true');
  });
  follow((state) => hasScan(state.draft), (there) => { why.hidden = there; });
  return [
    el('p', {class: 'quiet'}, t('new.layout_hint')),
    draftFields(schema, 'layout', arranged).element, why, el('p', null, button), layoutProgress()];
}

export function patternSection(schema: SettingsSchema): Children {
  const refused = el('div', {role: 'alert'});
  const zone = dropZone({
    id: 'pattern-choose', label: t('new.choose_pattern'), hint: t('new.pattern_hint'), accept: patternTypes, everywhere: true,
    take: (file) => { refused.replaceChildren(); void takePattern(file, file.name); },
    refused: (name) => refused.replaceChildren(el('p', {class: 'fault'}, t('new.wrong_pattern', {name})))});
  onEnd(zone.end);
  const now = draft();
  const arranging = 'layout' in schema.properties && (now.layout !== '' || (now.form.pattern?.layout ?? '') !== '');
  const ofScan = printsScan(now);
  const both = settingOf(now.form.settings, 'pattern.source') === 'both';
  const drawing = el('div', {hidden: arranging && !both || ofScan}, zone.element, refused);
  const array = 'layout' in schema.properties ? el('div', {hidden: !arranging || ofScan || both}, arrange(schema)) : null;
  const crossing = el('div', {hidden: ofScan}, el('h3', null, t('new.build_array')), draftFields(schema, 'array', built).element);
  const source = (value: string, label: string, on: boolean): HTMLElement => el('label', {class: 'choice'},
    el('input', {type: 'radio', name: 'pattern-source', value, checked: on, onchange: () => {
      const colours = value === 'scan' || value === 'both';
      setSetting('pattern.source', colours ? value : undefined);
      drawing.hidden = value !== 'drawing' && value !== 'both';
      if (array) array.hidden = value !== 'array';
      crossing.hidden = value === 'scan';
    }}), label);
  return [
    array && el('fieldset', null, el('legend', null, t('new.pattern_source')),
      el('div', {class: 'row'}, source('drawing', t('new.source_drawing'), !arranging && !ofScan && !both), source('array', t('new.source_array'), arranging && !ofScan && !both),
        source('scan', choiceOf('pattern.source', 'scan'), ofScan), source('both', choiceOf('pattern.source', 'both'), both))),
    drawing, array, transferLine('pattern'),
    live(({draft: {form, from}}) => [form.pattern, from, valueOf(schema, form.settings, 'pattern.width_mm'), valueOf(schema, form.settings, 'pattern.dpi'), form.settings['pattern']?.['source']] as const,
      () => !printsScan(draft()) && chosen(draft())),
    crossing, el('h3', null, t('new.place_pattern')), draftFields(schema, 'pattern', placed).element];
}
