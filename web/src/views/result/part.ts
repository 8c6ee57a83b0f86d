// The formed sheet in 3D with its maps, and everything that is read off it. Without WebGL: the pictures of the server.
import {el, newId, replace} from '../../dom';
import {api, artifactPath} from '../../api/client';
import type {Job} from '../../api/types';
import {identityOf, nameOf} from '../../parts/band';
import {titleOf} from '../../parts/downloads';
import {icon, type IconName} from '../../parts/icon';
import {kindsLegend, legend, type Legend} from '../../parts/legend';
import {problemBox} from '../../parts/problem';
import {split} from '../../parts/split';
import {readFormed} from '../../read/formed';
import {toJob} from '../../route';
import {announce, store} from '../../state';
import {centreLines, modes, queryOf, selected, type Coil, type HeatMap, type Line, type MapName, type PrintReport, type ResultState} from '../../state/result';
import {conducts} from '../../state/array';
import {wholeLines} from '../../state/ink';
import {colourAt, css, marksOf, noValue, touches, touchesNot} from '../../scene/colour';
import type {Sheet, Spot, Viewer} from '../../scene/sheet';
import {number, t, withUnit} from '../../text';
import {coilsAt, readings, readout, titleOfMap, valueOf} from './readout';
import {allShown, layerList, paintInk, type Layers} from './layers';
import {framed} from './picture';

type Place = readonly [number, number, number];
type Scene = typeof import('../../scene/sheet');

// How a drawing that is being moved is shown.
export interface Look {
  place: readonly number[] | null;  // puts the drawing there; null: the print
  pairs: readonly {from: Spot | null; to: Spot | null}[];  // numbered marks, joined by lines
}
export interface Part {
  element: HTMLElement;
  sheet(): Sheet | null;  // null without the 3D view
  showPlace(place: Place): void;
  look(now: (sheet: Sheet) => Look): void;  // called as soon as the 3D view is there
  // The next place that a person clicks or sets with M; null: there is nothing. undefined: it was cancelled.
  ask(words: string): Promise<Spot | null | undefined>;
}

const between = (places: readonly Place[]): Place =>
  [0, 1, 2].map((k) => places.reduce((sum, place) => sum + place[k]! / places.length, 0)) as unknown as Place;

export const setResult = (change: Partial<ResultState>): void => store.set((state) => ({result: {...state.result, ...change}}));

function pictures(job: Job, identity: string): HTMLElement {
  const files = job.artifacts.filter((file) => /^preview-(?!pattern|print)/.test(file.name));
  return el('div', {class: 'result-pictures'}, ...files.map((file) => el('figure', {class: 'card', 'data-file': file.name},
    el('img', {src: artifactPath(job.id, file.name), alt: t('result.picture_of', {title: titleOf(file), identity}), loading: 'lazy'}),
    el('figcaption', null, titleOf(file)))));
}

// What the 3D view needs; null: the job has no formed sheet. It is large, so it is asked for before the report is read.
export type Model = Promise<[Scene, ArrayBuffer]> | null;
export function loadModel(job: Job): Model {
  if (!job.artifacts.some((file) => file.name === 'formed.glb')) return null;
  const model = Promise.all([
    import('../../scene/sheet') as Promise<Scene>, api.artifact(job.id, 'formed.glb').then((answer) => answer.arrayBuffer())]);
  model.catch(() => {});  // the view says what is wrong
  return model;
}

export function partView(job: Job, report: PrintReport, model: Model, coils: readonly Coil[], layers: Layers, ends: (() => void)[]): Part {
  const identity = identityOf(job, report);
  const group = (name: string): Record<string, unknown> => job.settings[name] ?? {};
  const heatOf = (map: MapName): HeatMap | undefined => report.maps.find(({id}) => id === map);
  const titleOfShown = (map: MapName): string => {
    const heat = heatOf(map);
    return heat ? titleOfMap(heat) : t(map === 'contact' ? 'result.map_contact' : 'result.map_print');
  };
  const host = el('div', {class: 'result-view'}, el('p', {class: 'quiet', role: 'status'}, t('result.loading_3d')));
  const reading = readout();
  const legendHost = el('div', {class: 'legend-host'});
  let bar: Legend | null = null;
  let viewer: Viewer | null = null, sheet: Sheet | null = null, over = false;
  let lines: ReadonlyMap<string, Line[]> = new Map();
  let look: ((sheet: Sheet) => Look) | null = null;
  let {place, pairs}: Look = {place: null, pairs: []};
  let asked: ((spot: Spot | null | undefined) => void) | null = null;
  const found = new Map<string, [least: number, most: number]>();  // the values of a map
  let last: Spot | null = null;           // what the readout shows
  let marked: Spot | null = null;         // the place of a warning
  let measuring = false, still = false;
  const points: Spot[] = [];
  let way: [number, number][] = [];
  ends.push(() => {
    over = true;
    viewer?.dispose();
  });

  // ---- the choices beside the view
  const map = el('select', {id: 'result-map', onchange: () => setResult({map: map.value})},
                 ...['print', 'contact', ...report.maps.map(({id}) => id)].map((value) => el('option', {value}, titleOfShown(value))));
  const isolines = el('input', {type: 'checkbox', id: 'result-lines', onchange: () => setResult({isolines: isolines.checked})});
  const isolinesField = el('label', {class: 'choice', for: 'result-lines'}, isolines, t('result.isolines'));
  const modeButtons = modes.map((mode) => el('button', {type: 'button', onclick: () => setResult({mode})}, t(`result.mode_${mode}`)));
  const modeGroup = el('div', {class: 'row segments', role: 'group', 'aria-label': t('result.mode')}, ...modeButtons);
  const previewNote = el('p', {class: 'notice', role: 'status', hidden: true}, icon('info'), t('result.preview_shown'));

  const divider = split({
    label: t('result.split'), left: t('result.mode_drawn'), right: t('result.mode_with'),
    spoken: (share) => t('result.split_value', {share: Math.round(100 * (1 - share))}),
    change: (cut) => setResult({cut}),
  });
  const sideLabels = el('div', {class: 'side-labels'}, el('span', null, t('result.mode_drawn')), el('span', null, t('result.mode_with')));
  const keysId = newId('result-keys'), layerFault = el('div');

  // ---- measuring
  const measured = el('p', {class: 'measured', role: 'status'});
  const measureButton = el('button', {type: 'button', 'aria-pressed': 'false', onclick: () => {
    measuring = !measuring;
    measureButton.setAttribute('aria-pressed', String(measuring));
    if (!measuring) points.length = way.length = 0;
    measured.textContent = measuring ? t('result.measure_how') : '';
    paint();
  }}, t('result.measure'));
  function addPoint(spot: Spot | null): void {
    if (!spot || !sheet) return;
    if (points.length < 2) points.push(spot);
    else {  // the nearer end moves
      const [a, b] = points.map(({point}) => Math.hypot(...point.map((v, k) => v - spot.point[k]!)));
      points[a! < b! ? 0 : 1] = spot;
    }
    const [a, b] = points;
    way = [];
    if (a && b) {
      const found = sheet.way(a, b);
      way = found?.sheet ?? [];
      const straight = Math.hypot(...a.point.map((v, k) => v - b.point[k]!));
      measured.textContent = found ? t('result.measured', {length: withUnit(found.length, 'mm', 1), straight: withUnit(straight, 'mm', 1)})
                                   : t('result.no_way');
    } else measured.textContent = t('result.measure_second');
    paint();
  }

  // ---- what is marked on the sheet
  function paint(): void {
    const coils = selected(store.get().result);
    sheet?.draw((context) => {
      const style = getComputedStyle(host), accent = style.getPropertyValue('--mark').trim() || '#005eb8';
      const stroke = (trace: () => void, dashed = false): void => {
        for (const [colour, width] of [['#fff', 2.6], [accent, 1.4]] as const) {
          context.strokeStyle = colour;
          context.lineWidth = width;
          context.setLineDash(dashed && colour !== '#fff' ? [4, 3] : []);
          context.beginPath();
          trace();
          context.stroke();
        }
      };
      const along = (line: readonly (readonly [number, number])[]): void => line.forEach(([s, u], i) => i ? context.lineTo(s, u) : context.moveTo(s, u));
      const ring = ({sheet: [s, u]}: Spot, radius: number): void => stroke(() => context.arc(s, u, radius, 0, 7));
      context.lineJoin = context.lineCap = 'round';
      if (!place) for (const id of coils) stroke(() => lines.get(id)?.forEach(along));
      if (marked) for (const radius of [4, 9]) ring(marked, radius);
      if (way.length > 1) stroke(() => along(way), true);
      for (const point of points) ring(point, 1.6);
      for (const {from, to} of pairs) {
        if (from && to) stroke(() => along([from.sheet, to.sheet]), true);
        if (from) ring(from, 1.6);
        if (to) ring(to, 3);
      }
    }, !marked && points.length === 0 && pairs.length === 0);  // a coil alone is outlined where the print is, not on the drawing
  }
  const badges = el('div', {class: 'pair-badges', 'aria-hidden': 'true'});
  function placeBadges(): void {
    badges.replaceChildren(...pairs.flatMap(({from, to}, i) => {
      const spot = to ?? from, at = spot && sheet?.onScreen(spot);
      if (!at) return [];
      const badge = el('span', null, String(i + 1));
      badge.style.transform = `translate(${at.x}px, ${at.y}px)`;
      return [badge];
    }));
  }
  function relook(): void {
    if (look && sheet) ({place, pairs} = look(sheet));
    paint();
    apply(store.get().result);
  }

  // ---- asking for a place
  const question = el('div', {role: 'status'});
  const answer = (spot: Spot | null | undefined): void => {
    question.replaceChildren();
    asked?.(spot);
  };
  function ask(words: string): Promise<Spot | null | undefined> {
    answer(undefined);
    return new Promise((resolve) => {
      asked = (spot) => {
        asked = null;
        resolve(spot);
      };
      replace(question, el('div', {class: 'notice'}, icon('info'), el('div', null, el('p', null, words),
        el('button', {type: 'button', onclick: () => answer(undefined)}, icon('cancel'), t('shell.cancel')))));
      question.scrollIntoView({block: 'nearest'});
      viewer?.canvas.focus({preventScroll: true});
    });
  }

  function read(spot: Spot | null, aloud = false): void {
    if (!spot) {
      if (aloud) announce(t('result.nothing_there'));
      bar?.mark(null);
      return;
    }
    last = spot;
    const rows = readings(spot, report.maps, lines), {map: shown} = store.get().result;
    reading.show(rows);
    bar?.mark(spot.values.get(shown) ?? null);
    if (aloud) announce(rows.map(([name, value]) => `${name}: ${value}`).join('; '));
  }

  // ---- the layers of the print
  const list = layers.all.length > 0 ? layerList(layers, t('array.layers_part'), (hidden) => setResult({hidden})) : null;
  async function showInk(): Promise<void> {
    const {hidden} = store.get().result;
    if (allShown(layers, {hidden})) return sheet?.ink(null);
    const inks = await layers.inks();
    if (!over && hidden.join() === store.get().result.hidden.join()) sheet?.ink((context) => paintInk(context, layers, inks, hidden));
  }

  // ---- following the state
  function showLegend(shown: MapName): void {
    const heat = heatOf(shown);
    bar = null;
    if (heat) {
      const {low, high, limit} = heat, [least, most] = found.get(heat.id) ?? [low, high];
      bar = legend({
        title: titleOfMap(heat), unit: heat.unit, low, high, marks: marksOf(heat), limit: limit ?? undefined,
        found: found.has(heat.id) ? t('result.from_to', {from: valueOf({...heat, unit: ''}, least), to: valueOf({...heat, unit: ''}, most)}) : undefined,
        limitText: limit === null ? '' : t('result.limit', {value: number(limit, 2)}),
        colours: heat.colours,
        below: least < low ? t('result.below', {value: valueOf(heat, low)}) : '',
        above: most > high ? t('result.above', {value: valueOf(heat, high)}) : ''});
    }
    legendHost.replaceChildren(...(bar ? [bar.element] : shown === 'contact'
      ? [kindsLegend(t('result.map_contact'), [{text: t('result.contact_mold'), colour: css(touches)},
                                               {text: t('result.contact_free'), colour: css(touchesNot), hatched: true},
                                               {text: t('result.contact_elsewhere'), colour: css(noValue)}])] : []));
    if (last && bar) bar.mark(last.values.get(shown) ?? null);
  }
  let before: ResultState | null = null;
  function apply(now: ResultState): void {
    if (before?.map !== now.map) showLegend(now.map);
    const heat = heatOf(now.map), shown = heat ?? (now.map === 'contact' ? 'contact' : 'print');
    map.value = heat ? heat.id : now.map === 'contact' ? 'contact' : 'print';
    isolines.checked = now.isolines;
    isolinesField.hidden = !heat;
    modeButtons.forEach((button, i) => button.setAttribute('aria-pressed', String(modes[i] === now.mode)));
    const moved = place !== null;
    previewNote.hidden = !moved || !sheet;
    modeGroup.hidden = moved;
    divider.element.hidden = moved || now.mode !== 'split';
    sideLabels.hidden = moved || now.mode !== 'side';
    sheet?.show({
      map: shown, isolines: now.isolines, sideBySide: !moved && now.mode === 'side',
      cut: now.mode === 'drawn' ? 1 : now.mode === 'split' ? now.cut : 0, place});
    if (now.mode === 'split' && (before?.mode !== 'split' || before.cut !== now.cut)) divider.set(now.cut);
    if (before && selected(before).join() !== selected(now).join()) {
      paint();
      const chosen = coils.filter(({id}) => id === now.coil || id === now.other);
      if (chosen.length > 0 && !still) sheet?.turnTo(between(chosen.map(({centre}) => centre)));
    }
    list?.show(now.hidden);
    if (sheet && before?.hidden.join() !== now.hidden.join())
      void showInk().catch((error: unknown) => { replace(layerFault, problemBox(error, () => void showInk())); });
    if (before && before.camera !== now.camera && now.camera && viewer) viewer.camera = now.camera;
    viewer?.setSummary(summary(now));
    before = now;
    keepAddress();
  }
  function summary(now: ResultState): string {
    const worst = Math.max(0, ...coils.filter((coil) => coil.onHead).map((coil) => coil.round));
    return [t('result.summary', {map: titleOfShown(now.map), thinnest: withUnit(report.thickness.least_mm, 'mm', 2)}),
            coils.length > 0 && t('result.summary_coils', {count: coils.length, worst: `${number(100 * worst, 1)} %`})].filter(Boolean).join(' ');
  }
  // The address always restores the view, also after a reload.
  function keepAddress(): void {
    const route = store.get().route;
    if (over || route.view !== 'job' || route.id !== job.id) return;
    history.replaceState(null, '', toJob(job.id, queryOf({...store.get().result, camera: viewer?.camera ?? store.get().result.camera})));
  }

  // ---- link and picture
  const linkField = el('input', {type: 'text', readonly: true, hidden: true, 'aria-label': t('result.link')});
  async function copyLink(): Promise<void> {
    keepAddress();
    try {
      await navigator.clipboard.writeText(location.href);
      announce(t('result.link_copied'));
    } catch {  // pages without TLS may not use the clipboard
      linkField.value = location.href;
      linkField.hidden = false;
      linkField.select();
    }
  }
  async function savePicture(): Promise<void> {
    if (!viewer) return;
    const {map: shown, mode, cut} = store.get().result, heat = heatOf(shown);
    const names: [string, string] = [t('result.mode_drawn'), t('result.mode_with')];
    const blob = await framed(viewer.snapshot(), {
      identity, view: [t('viewer.spoken', {view: viewer.viewWords()}), way.length > 0 && measured.textContent].filter(Boolean).join(' '),
      title: place ? t('result.preview_title') : shown === 'print' && mode !== 'split' && mode !== 'side' ? t(`result.mode_${mode}`) : titleOfShown(shown),
      ...(mode === 'side' && !place && {halves: names}),
      ...(mode === 'split' && !place && {cut: {share: cut, left: names[0], right: names[1]}}),
      ...(heat && {colours: {
        css: Array.from({length: 21}, (_, i) => css(colourAt(heat, i / 20))), unit: heat.unit,
        marks: marksOf(heat).map((mark) => [(mark - heat.low) / (heat.high - heat.low), number(mark)] as const)}}),
    });
    const url = URL.createObjectURL(blob);
    el('a', {href: url, download: `${nameOf(job).replace(/[^\w.-]+/g, '-')}-${shown}.png`}).click();
    setTimeout(() => URL.revokeObjectURL(url), 10_000);
    announce(t('result.picture_saved'));
  }
  const tool = (name: IconName, text: string, act: () => void): HTMLButtonElement =>
    el('button', {type: 'button', onclick: act}, icon(name), text);

  // ---- loading
  const fallback = (why: string): void => {
    answer(undefined);
    viewer = sheet = null;
    host.replaceChildren(el('p', {class: 'notice'}, icon('info'), why), pictures(job, identity));
    element.classList.add('flat');
  };
  async function load(loading: Model): Promise<void> {
    if (!loading) return fallback(t('result.no_formed'));
    try {
      const [scene, file] = await loading;
      if (over) return;
      try {
        viewer = scene.createViewer({label: t('result.view_label', {job: nameOf(job)}), elevation: 38, failed: () => fallback(t('result.lost_3d'))});
      } catch (error) {
        if (!(error instanceof scene.NoWebGl)) throw error;
        return fallback(t('result.no_webgl'));
      }
      const {camera} = store.get().result;
      replace(host, viewer.element);
      const side = group('scan')['left_side'];
      const formed = readFormed(file);
      for (const [id, values] of formed.maps) {
        const known = values.filter((value) => value >= 0), ends = [Math.min, Math.max].map((of) => known.reduce((a, b) => of(a, b), known[0] ?? 0));
        found.set(id, [ends[0]!, ends[1]!]);
      }
      const made = await scene.createSheet(viewer, formed, side === 'minus_x' || side === 'plus_x' ? side : 'unknown');
      if (over) return;
      sheet = made;
      viewer.frame.append(divider.element, sideLabels, badges);
      if (camera) viewer.camera = camera;
      before = null;
      relook();
      listen(viewer, made);
    } catch (error) {
      if (over) return;
      viewer?.dispose();
      replace(host, [problemBox(error, () => void load(loadModel(job))), pictures(job, identity)]);
    }
  }
  // The centre lines come from the print itself; without them coils cannot be outlined.
  async function loadLines(): Promise<void> {
    if (coils.length === 0) return;
    const names = layers.all.length > 0 ? layers.all.filter(conducts).map(({name}) => name) : ['print'];
    lines = wholeLines((await Promise.all(names.map(layers.text))).map(centreLines));
    paint();
  }

  function listen(view: Viewer, made: Sheet): void {
    const {canvas} = view;
    canvas.setAttribute('aria-describedby', `${canvas.getAttribute('aria-describedby') ?? ''} ${keysId}`.trim());
    let pending: PointerEvent | null = null;
    canvas.addEventListener('pointermove', (event) => {
      if (event.buttons !== 0 || event.pointerType === 'touch') return;
      if (!pending) requestAnimationFrame(() => {
        if (pending && !over) read(made.under(pending));
        pending = null;
      });
      pending = event;
    });
    canvas.addEventListener('pointerleave', () => { pending = null; });
    view.hand = {
      tap(event) {
        const spot = made.under(event);
        read(spot);
        if (asked) return answer(spot);
        if (measuring) return addPoint(spot);
        const hit = spot ? coilsAt(spot, lines) : [], {coil} = store.get().result;
        if (hit.length > 0) choose(hit[(hit.indexOf(coil) + 1) % hit.length] ?? '');
      },
      escape() { if (asked) answer(undefined); },
      key(key) {
        const {mode} = store.get().result;
        if (key === 'i') read(made.under(), true);
        else if (key === 'b') setResult({mode: mode === 'with' ? 'drawn' : 'with'});
        else if (asked && key === 'm') answer(made.under());
        else if (key === 'm') {
          if (!measuring) measureButton.click();
          addPoint(made.under());
        } else return false;
        return true;
      },
    };
    view.on('rest', keepAddress);
    view.on('theme', paint);
    view.on('frame', placeBadges);
  }
  // Without turning the view: the coil is where the person clicked.
  function choose(id: string): void {
    still = true;
    setResult({coil: id, other: ''});
    still = false;
  }

  const element = el('div', {class: 'result-part'},
    el('section', {class: 'card result-map'},
      el('label', {for: 'result-map'}, t('result.map')), map, isolinesField, legendHost, list?.element, layerFault),
    el('div', {class: 'result-main'}, modeGroup, previewNote, question, host),
    el('div', {class: 'result-side'},
      reading.element,
      el('section', {class: 'card stack'},
        el('h3', null, t('result.tools')),
        el('div', {class: 'row'}, measureButton, tool('download', t('result.save_picture'), () => void savePicture()),
          tool('copy', t('result.copy_link'), () => void copyLink())),
        measured, linkField, el('p', {class: 'small quiet', id: keysId}, t('result.keys')))));
  ends.push(store.subscribe((state) => {
    if (!over && state.result !== before) apply(state.result);
  }));
  apply(store.get().result);
  void load(model);
  void loadLines().catch(() => {});

  return {
    element,
    showPlace(at) {
      if (!sheet || !viewer) {  // the picture has the places of all warnings
        host.querySelector('[data-file="preview-findings.png"]')?.scrollIntoView({block: 'nearest'});
        return;
      }
      marked = sheet.nearest(at);
      sheet.turnTo(at);
      paint();
      read(marked, true);
      viewer.element.scrollIntoView({block: 'nearest'});
      viewer.canvas.focus({preventScroll: true});
    },
    look(now) {
      look = now;
      relook();
    },
    sheet: () => sheet,
    ask,
  };
}
