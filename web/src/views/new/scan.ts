// Section 1 of a new print: the scan. It is read in this browser, shown in the machine and placed there, before the server
// has it. Without WebGL the figures and fields do the same.
//
// Properties: `settings` (scan, sheet, machine, pattern: what differs from the defaults), `inspected` (what the service
// found), `mold` (the one that it made, for a scan that this browser cannot show), `drawing`.
// Events: "file" {file}, "facts" (suspicions), "change" {settings}. `show(place)` marks a place in mm.
import {el, newId, replace, type Children} from '../../dom';
import type {Settings} from '../../api/types';
import {dropZone} from '../../parts/drop-zone';
import {icon} from '../../parts/icon';
import {numberField, type NumberField} from '../../parts/number-field';
import {readScanFile, ScanFault} from '../../parts/reader';
import {axes, inMillimetres, plausible, sizesOf, unitOf, units, type Axis, type Unit} from '../../read/facts';
import {frontPicture} from '../../read/front';
import {landmarks, straighten, type Point, type Straight} from '../../read/landmarks';
import {frontOfGltf, place, quartered, tilting, wrapped, type Placed, type Placement} from '../../read/place';
import type {ReadScan} from '../../read/prepare';
import type {LeftSide} from '../../scene/orbit';
import type {Frame, Ink, ScanScene} from '../../scene/scan';
import {announce} from '../../state';
import {bytes, duration, number, t} from '../../text';
import {onEnd, View} from '../../view';

export interface Suspicions {
  plausible: boolean;  // the size, in the chosen unit, is one of a head
  mirrored: boolean;   // the scan may be a mirror image
  upGuessed: boolean;  // nothing in the file says which axis points up
  wide: boolean;       // it does not fit through the window
}
export type Drawing = Pick<Ink, 'picture' | 'size'>;
type Values = Record<string, unknown>;
type Turn = 'yaw' | 'roll' | 'pitch';

const archive = '.zip';  // a model with its textures, which only the service unpacks
const extensions = ['.stl', '.obj', '.ply', '.off', '.glb', archive];
const fronts = ['+y', '+x', '-y', '-x'] as const;  // by quarter turns
const hopeless = ['empty', 'foreign', 'unknown', 'damaged'];  // the server would refuse them too

const millimetres = (values: readonly number[]): string => `${values.map((value) => number(value, 0)).join(' × ')} mm`;
const choice = <T extends string>(value: unknown, of: readonly T[], fallback: T): T => of.find((one) => one === value) ?? fallback;
const longest = ({facts}: ReadScan): number => Math.max(...facts.low.map((value, k) => facts.high[k]! - value));
const likeHead = ({like}: {like: string}): boolean => like === 'adult' || like === 'newborn';
const turns: readonly Turn[] = ['yaw', 'roll', 'pitch'];
const warning = (text: string, role?: string): HTMLElement => el('p', {class: 'notice', role}, icon('warning'), el('span', null, text));
const keptUnder = 'vacuform.scan';  // tells whether a file that is chosen after a reload is the same

class ScanSection extends View {
  #settings: Settings = {};
  #scan: {file: File; read: ReadScan; ms: number} | null = null;
  #scene: ScanScene | null = null;
  #flat = false;                       // there is no WebGL
  #outline = true;
  #drawing: Drawing | null = null;
  #mold: ReadScan | null = null;
  #trim: number | null = null;         // the height at which the service cuts
  #stands: Placed | null = null;       // where the settings place the scan
  #marks: (Point | undefined)[] = [];  // the landmarks, where the file has them; they are never sent
  #marking = -1;                       // the landmark that a click sets
  #turning = false;                    // a drag turns the scan, not the camera
  #drag: {right: number; down: number; from: number; sign: number; values: Values} | null = null;  // degrees; what it sets
  #turned: Turn | null = null;         // by the last drag
  #answered: Record<string, number> = {};  // the angles at which a person said where the left is
  #told = '';                          // the suspicions that were told last
  #reading = new AbortController();
  #update = (): void => {};

  get settings(): Settings { return this.#settings; }
  set settings(settings: Settings) {
    this.#settings = settings;
    this.#update();
  }
  set inspected(found: {trim_mm?: number} | null) {
    this.#trim = found?.trim_mm ?? null;
    this.#update();
  }
  set mold(mold: ReadScan | null) {
    this.#mold = mold;
    this.#update();
  }
  // Of the scan that this browser has read; null without one.
  get suspicions(): Suspicions | null { return this.#scan && this.#suspicions(this.#scan.read); }
  set drawing(drawing: Drawing | null) {
    this.#drawing = drawing;
    this.#update();
  }
  show(mm: readonly number[]): void {
    this.#scene?.mark(mm);
    this.#scene?.viewer.element.scrollIntoView({block: 'nearest'});
    if (!this.#scene) announce(t('scan.place', {x: mm[0] ?? 0, y: mm[1] ?? 0, z: mm[2] ?? 0}));
  }

  // --- the settings as this section uses them
  #value(group: string, key: string): unknown { return (group === 'scan' ? this.#drag?.values[key] : null) ?? this.#settings[group]?.[key]; }
  #number(group: string, key: string, fallback: number): number {
    const value = this.#value(group, key);
    return typeof value === 'number' ? value : fallback;
  }
  get #unit(): Unit | undefined { return units.find((unit) => unit === this.#value('scan', 'units')); }
  get #up(): Axis { return choice(this.#value('scan', 'up'), axes, this.#scan?.read.facts.up.axis ?? '+z'); }
  get #front(): Placement['front'] {
    const told = this.#scan?.read.facts.zFront && frontOfGltf({up: this.#up, mirror: this.#mirror === 'yes', roll: this.#angle('roll'), pitch: this.#angle('pitch')});
    return choice(this.#value('scan', 'front'), fronts, told || '+y');
  }
  get #left(): LeftSide { return choice(this.#value('scan', 'left_side'), ['minus_x', 'plus_x', 'unknown'], 'unknown'); }
  get #mirror(): 'yes' | 'no' | 'auto' { return choice(this.#value('scan', 'mirror'), ['yes', 'no', 'auto'], 'auto'); }
  get #plug(): number { return this.#number('machine', 'plug_height_mm', 0); }

  #scale(read: ReadScan): number {
    const side = longest(read), given = this.#value('scan', 'size_mm');
    if (typeof given === 'number') return given / side;
    // without a unit the scan is shown as large as a head
    return this.#unit ? inMillimetres(this.#unit) : 200 / side;
  }
  #frame(): Frame {
    const width = this.#number('machine', 'window_width_mm', 280), round = this.#value('machine', 'window') === 'circle';
    return {sheet: [this.#number('sheet', 'width_mm', 300), this.#number('sheet', 'height_mm', 300)], round,
            window: [width, round ? width : this.#number('machine', 'window_height_mm', 280)],
            height: this.#number('machine', 'drape_height_mm', 0)};
  }
  #angle(turn: Turn): number { return this.#number('scan', `${turn}_deg`, 0); }
  #placed(read: ReadScan): Placed {
    return place(read.shown.positions, {
      scale: this.#scale(read), up: this.#up, mirror: this.#mirror === 'yes', roll: this.#angle('roll'), pitch: this.#angle('pitch'),
      front: this.#front, yaw: this.#angle('yaw')}, this.#number('scan', 'trim_mm', this.#trim ?? 0), this.#plug);
  }
  // The first landmark that is not set, or -1.
  #missing(): number { return landmarks.findIndex((_, i) => !this.#marks[i]); }
  #straight(): Straight | null {
    return this.#scan && this.#missing() < 0
      ? straighten(this.#marks as Point[], {scale: this.#scale(this.#scan.read), up: this.#up, mirror: this.#mirror === 'yes'}) : null;
  }
  #suspicions(read: ReadScan): Suspicions {
    const known = this.#unit !== undefined || typeof this.#value('scan', 'size_mm') === 'number';
    return {plausible: known && plausible(longest(read) * this.#scale(read)),
            mirrored: this.#left === 'plus_x' || (read.facts.insideOut && this.#mirror === 'auto'),
            upGuessed: !read.facts.up.told && this.#up === read.facts.up.axis, wide: known && this.#wide(read)};
  }

  #wide(read: ReadScan): boolean {
    const {half: [x, y]} = this.#stands ?? this.#placed(read), {window: [w, h], round} = this.#frame();
    return round ? Math.max(x, y) > w / 2 : x > w / 2 || y > h / 2;
  }

  // --- what goes out
  #change(values: Values): void {
    const front = values['front'] ?? this.#value('scan', 'front'), yaw = values['yaw_deg'] ?? this.#angle('yaw');
    if (front !== 'auto' && typeof yaw === 'number' && Math.abs(yaw) > 45) {
      const same = quartered(choice(front, fronts, '+y'), yaw);
      values = {...values, front: same.front, yaw_deg: same.yaw};
    }
    // a scan that stands differently needs a new look at its sides; small turns add up
    const differs = ['up', 'front', 'mirror'].some((key) => key in values) || turns.some((turn) => {
      const to = values[`${turn}_deg`], from = this.#answered[turn] ??= this.#angle(turn);
      return typeof to === 'number' && Math.abs(wrapped(to - from)) >= 45;
    });
    if (differs && this.#left !== 'unknown' && !('left_side' in values)) values = {...values, left_side: 'unknown'};
    if ('left_side' in values) this.#answered = {};
    this.#settings = {...this.#settings, scan: {...this.#settings['scan'], ...values}};
    this.#update();
    this.dispatchEvent(new CustomEvent('change', {detail: {settings: {scan: values}}, bubbles: true}));
  }
  // Also a larger window or another profile can settle a doubt.
  #tellFacts(): void {
    const facts = this.#scan && this.#suspicions(this.#scan.read), now = JSON.stringify(facts);
    if (!facts || now === this.#told) return;
    this.#told = now;
    this.dispatchEvent(new CustomEvent('facts', {detail: facts, bubbles: true}));
  }
  #send(file: File): void {
    this.dispatchEvent(new CustomEvent('file', {detail: {file}, bubbles: true}));
  }

  protected build(): Children {
    const news = el('div', {class: 'scan-news'}), stage = el('div', {class: 'scan-stage'});
    const body = el('div', {class: 'scan-body'}, stage, this.#fields());
    const zone = dropZone({
      id: 'scan-file', label: t('scan.choose'), hint: t('scan.drop_hint'), accept: extensions, everywhere: true,
      take: (file) => void this.#take(file, news, stage),
      refused: (name) => replace(news, el('p', {class: 'fault', role: 'alert'}, t('scan.other_kind', {name})))});
    const follow = this.#update;
    this.#update = () => {
      body.hidden = !this.#scan && !this.#settings['scan'];
      this.#stands = this.#scan && this.#placed(this.#scan.read);
      follow();
      this.#standing();
      this.#tellFacts();
    };
    onEnd(() => {
      zone.end();
      this.#reading.abort();
      this.#scene?.viewer.dispose();
    });
    this.#update();
    return [zone.element, news, body];
  }

  async #take(file: File, news: HTMLElement, stage: HTMLElement): Promise<void> {
    this.#reading.abort();
    const {signal} = this.#reading = new AbortController();
    if (file.name.toLowerCase().endsWith(archive)) return this.#takeUnread(file, news, stage);
    const bar = el('progress', {max: 1, value: 0, 'aria-label': t('scan.reading', {name: file.name})});
    replace(news, el('div', {class: 'row', role: 'status'}, el('span', null, t('scan.reading', {name: file.name})), bar,
      el('button', {type: 'button', onclick: () => { this.#reading.abort(); replace(news, null); }}, icon('cancel'), t('shell.cancel'))));
    const began = performance.now();
    try {
      const read = await readScanFile(file, (share) => { bar.value = share; }, signal);
      this.#scan = {file, read, ms: performance.now() - began};
      this.#told = '';
      this.#trim = this.#drag = null;
      this.#marks = [];
      replace(news, null);
      this.#scene?.viewer.dispose();
      this.#scene = null;
      const mark = [file.name, file.size, file.lastModified].join(' '), again = sessionStorage.getItem(keptUnder) === mark;
      sessionStorage.setItem(keptUnder, mark);
      // What is shown is what is sent: unit and axis are set, also where they are guesses.
      const values: Values = again && this.#settings['scan'] ? {} : {
        units: unitOf(read.facts) ?? 'auto', up: read.facts.up.axis, left_side: 'unknown', size_mm: 'auto', front: 'auto', mirror: 'auto',
        yaw_deg: 0, roll_deg: 0, pitch_deg: 0, trim_mm: 'auto', body: 'auto'};
      this.#settings = {...this.#settings, scan: {...this.#settings['scan'], ...values}};
      this.#send(file);
      this.#change(values);
      announce(t('scan.read', {triangles: read.facts.triangles}));
      await this.#stand(stage);
    } catch (error) {
      if (signal.aborted) return;
      if (!(error instanceof ScanFault)) throw error;
      this.#scan = null;
      replace(stage, null);
      replace(news, this.#faultBox(file, error));
      this.#update();
    }
  }

  #takeUnread(file: File, news: HTMLElement, stage: HTMLElement): void {
    this.#scan = this.#drag = this.#trim = null;
    this.#marks = [];
    this.#scene?.viewer.dispose();
    this.#scene = null;
    replace(stage, null);
    replace(news, el('p', {class: 'notice', role: 'status'}, icon('info'), el('span', null, t('scan.archive', {name: file.name}))));
    this.#send(file);
    this.#change({units: 'auto', up: 'auto', left_side: 'unknown', size_mm: 'auto', front: 'auto', mirror: 'auto', yaw_deg: 0, roll_deg: 0,
                  pitch_deg: 0, trim_mm: 'auto', body: 'auto'});
  }

  #faultBox(file: File, {body: {fault, where, detail}}: ScanFault): HTMLElement {
    const id = newId('scan-fault');
    return el('section', {class: 'problem', role: 'alert', 'aria-labelledby': id},
      el('h2', {id}, icon('error'), t('scan.unread')),
      el('p', null, t(`scan.fault_${fault}`, {detail})),
      el('p', null, t('problem.where', {where: where ? `${file.name}, ${t(`scan.at_${where.unit}`, {at: where.at})}` : file.name})),
      el('p', null, t('problem.fix', {fix: t(`scan.fix_${fault}`)})),
      !hopeless.includes(fault) && el('p', null, el('button', {type: 'button', onclick: (event: Event) => {
        (event.currentTarget as HTMLElement).remove();
        this.#send(file);
      }}, icon('upload'), t('scan.send_anyway'))));
  }

  // Builds the 3D view.
  async #stand(stage: HTMLElement): Promise<void> {
    const scan = this.#scan;
    if (!scan) return;
    const flat = (): void => {
      this.#flat = true;
      this.#scene = null;
      replace(stage, el('p', {class: 'notice', role: 'status'}, icon('info'), el('span', null, t('scan.no_3d'))));
      this.#update();
    };
    if (this.#flat) return flat();
    const {scanScene, NoWebGl} = await import('../../scene/scan');
    if (this.#scan !== scan || !this.isConnected) return;
    try {
      this.#scene = scanScene(scan.read, {label: t('scan.view'), tools: [this.#turnButton], failed: flat});
      const {element, frame} = this.#scene.viewer;
      frame.append(this.#note);
      replace(stage, element);
      this.#use(-1, false);
    } catch (error) {
      if (!(error instanceof NoWebGl)) throw error;
      flat();
    }
  }
  #standing(): void {
    const placed = this.#stands, marking = landmarks[this.#marking];
    if (!this.#scene || !placed) return;
    this.#note.textContent = marking ? t('scan.mark_now', {name: t(`scan.mark_${marking}`)})
      : !this.#turning ? '' : this.#turned ? this.#said(this.#turned) : t('scan.turn_hint');
    this.#note.hidden = !this.#note.textContent;
    this.#turnButton.setAttribute('aria-pressed', String(this.#turning));
    this.#scene.update({placed, plug: this.#plug, frame: this.#frame(), left: this.#left, outline: this.#outline, ink: this.#ink(), marks: this.#marks});
    this.#scene.viewer.setSummary(t('scan.summary', {size: millimetres(placed.size), view: this.#scene.viewer.viewWords()}));
  }

  #ink(): Ink | null {
    const offset = this.#value('pattern', 'offset_mm') as [number, number] | undefined;
    return this.#drawing && {...this.#drawing, offset: offset ?? [0, 0], turn: this.#number('pattern', 'rotate_deg', 0), scale: this.#number('pattern', 'scale', 1)};
  }

  // --- the hand in the 3D view
  readonly #note = el('p', {class: 'view3d-note small'});  // says what it does now
  readonly #turnButton = el('button', {type: 'button', onclick: () => this.#use(this.#marking, !this.#turning)}, t('scan.turn'));

  // A click sets the landmark `marking` (-1: none). A drag turns the scan, or else the camera.
  #use(marking: number, turning: boolean): void {
    const {viewer} = this.#scene!;
    this.#rest();
    this.#marking = marking;
    this.#turning = turning;
    this.#turned = null;
    viewer.hand = {
      tap: (event) => { if (marking >= 0) this.#mark(event); },
      turn: turning ? (...hand) => this.#turn(...hand) : null,
      rest: () => this.#rest(),
      escape: () => this.#use(-1, false),
      key: (key) => key === 'm' && (this.#mark(), true)};
    this.#update();
    if (marking < 0 && !turning) return;
    viewer.canvas.focus();
    announce(this.#note.innerText);
  }

  // Sets the landmark, or the first that is missing, where a person clicked or at the centre of the view.
  #mark(event?: MouseEvent): void {
    const i = this.#marking < 0 ? this.#missing() : this.#marking, point = this.#scene!.under(event);
    if (i < 0) return;
    if (!point) return announce(t('result.nothing_there'));
    this.#marks[i] = point;
    this.#use(this.#missing(), this.#turning);  // says what comes next
    if (this.#marking < 0) document.getElementById('scan-straighten')?.focus();
  }

  // Once the landmarks are set.
  #straighten(): void {
    const straight = this.#straight();
    if (!straight) return;
    const {roll, pitch, front, yaw, flipped} = straight;
    this.#change({up: this.#up, roll_deg: roll, pitch_deg: pitch, front, yaw_deg: yaw, left_side: flipped ? 'plus_x' : 'minus_x'});
    this.#scene?.viewer.setView('front');
    announce(turns.map(this.#said, this).join('; '));
  }

  #said(turn: Turn): string { return `${t(`scan.turn_${turn}`)}: ${number(this.#angle(turn))}°`; }

  // A drag changes one number, the one that its first movement chooses. It is shown at once; it counts when the hand rests,
  // so that one undo takes back the whole drag.
  #turn(right: number, down: number, snap: boolean, azimuth: number): void {
    const drag = this.#drag ??= {right: 0, down: 0, from: 0, sign: 0, values: {}};
    drag.right += right;
    drag.down += down;
    if (!drag.sign) {
      if (Math.hypot(drag.right, drag.down) < 1) return;
      [this.#turned, drag.sign] = Math.abs(drag.right) >= Math.abs(drag.down) ? ['yaw', 1] : tilting(azimuth, this.#front, this.#angle('yaw'));
      drag.from = this.#angle(this.#turned);
    }
    const turn = this.#turned!, step = snap ? 5 : 0.1, to = drag.from + drag.sign * (turn === 'yaw' ? drag.right : drag.down);
    drag.values = {[`${turn}_deg`]: wrapped(Math.round(to / step) * step)};
    this.#update();
    this.#scene?.viewer.invalidate(true);
  }
  #rest(): void {
    const drag = this.#drag, turn = this.#turned;
    this.#drag = null;
    if (!drag?.sign || !turn) return;
    this.#change(drag.values);
    announce(this.#said(turn));
  }

  // --- the fields; each adds what it does when the settings change to `follows`
  #fields(): HTMLElement {
    const follows: (() => void)[] = [];
    this.#update = () => { for (const follow of follows) follow(); };
    const host = (build: () => Children): HTMLElement => {
      const element = el('div', {class: 'live'});
      follows.push(() => {  // only what changed: an alert is not to be spoken again
        const next = el('div', null, build());
        if (next.innerHTML !== element.innerHTML) replace(element, [...next.childNodes]);
      });
      return element;
    };
    const angle = (turn: Turn): HTMLElement => {
      const key = `${turn}_deg`, label = t(`scan.turn_${turn}`), row = this.#numberRow(follows, key, label, -180, 180, '°');
      row.lastElementChild?.firstElementChild?.append(...([[-5, '−5°'], [5, '+5°']] as const).map(([by, text]) =>
        el('button', {type: 'button', 'aria-label': t('scan.turn_by', {by: text, label}), onclick: () => {
          this.#change({[key]: wrapped(this.#angle(turn) + by)});
        }}, text)));
      return row;
    };
    return el('div', {class: 'scan-fields'},
      host(() => this.#drawing && this.#scene && el('p', {class: 'small'}, t('scan.ink'))),
      host(() => this.#factList()),
      this.#unitChoice(follows, host),
      el('fieldset', null, el('legend', null, t('scan.up')), host(() => this.#upHint()),
        el('div', {class: 'axes'}, axes.map((axis) => {
          const button = el('button', {type: 'button', class: 'axis', 'aria-label': t('scan.up_axis', {axis}), onclick: () => this.#change({up: axis})}, axis.replace('-', '−'));
          follows.push(() => button.setAttribute('aria-pressed', String(this.#up === axis)));
          return button;
        }))),
      this.#landmarkFields(follows, host),
      el('fieldset', null, el('legend', null, t('scan.front')), el('p', {class: 'hint'}, t('scan.front_hint')),
        el('div', {class: 'row'},
          ([['undo', 1, t('scan.turn_left')], ['redo', -1, t('scan.turn_right')]] as const).map(([name, by, text]) =>
            el('button', {type: 'button', onclick: () => {
              this.#change({front: fronts[(fronts.indexOf(this.#front) + by + 4) % 4]});
              announce(t('scan.turned', {front: this.#front}));
            }}, icon(name), text)))),
      angle('yaw'),
      this.#trimRow(follows),
      this.#sides(follows, host),
      el('details', null, el('summary', null, t('scan.more')),
        angle('roll'), angle('pitch'),
        this.#select(follows, 'mirror', t('scan.mirror'), t('scan.mirror_hint'), [['auto', t('scan.mirror_auto')], ['no', t('scan.mirror_no')], ['yes', t('scan.mirror_yes')]]),
        this.#select(follows, 'front', t('scan.front_side'), '', [['auto', t('settings.automatic')], ...fronts.map((side): [string, string] => [side, side])]),
        this.#select(follows, 'up', t('scan.up'), '', [['auto', t('settings.automatic')], ...axes.map((side): [string, string] => [side, side])]),
        this.#outlineBox()));
  }

  #landmarkFields(follows: (() => void)[], host: (build: () => Children) => HTMLElement): HTMLElement {
    const fields = el('fieldset', null, el('legend', null, t('scan.landmarks')), el('p', {class: 'hint'}, t('scan.landmarks_hint')),
      el('div', {class: 'row'}, landmarks.map((name, i) => {
        const button = el('button', {type: 'button', onclick: () => this.#use(this.#marking === i ? -1 : i, this.#turning)});
        follows.push(() => {
          const set = this.#marks[i] !== undefined;
          button.setAttribute('aria-pressed', String(this.#marking === i));
          replace(button, [set && icon('check'), `${t(`scan.mark_${name}`)}: ${t(set ? 'scan.mark_set' : 'scan.mark_open')}`]);
        });
        return button;
      })),
      host(() => {
        const straight = this.#straight();
        return this.#missing() < 0 && [
          (!straight || straight.flipped) && warning(t(straight ? 'scan.flipped' : 'scan.misplaced'), 'alert'),
          straight && el('button', {type: 'button', class: 'primary', id: 'scan-straighten', onclick: () => this.#straighten()}, t('scan.straighten'))];
      }));
    follows.push(() => { fields.hidden = !this.#scene; });
    return fields;
  }

  #outlineBox(): HTMLElement {
    const box = el('input', {type: 'checkbox', checked: this.#outline, onchange: () => {
      this.#outline = box.checked;
      this.#standing();
    }});
    return el('label', {class: 'choice'}, box, t('scan.outline'));
  }

  #factList(): Children {
    const scan = this.#scan;
    if (!scan) return el('p', {class: 'hint'}, t('scan.fields_only'));
    const {facts} = scan.read, placed = this.#stands ?? this.#placed(scan.read), frame = this.#frame(), doubt = this.#suspicions(scan.read);
    const row = (name: string, value: string): Children => [el('dt', null, name), el('dd', null, value)];
    return [
      el('dl', {class: 'facts'}, row(t('scan.name'), scan.file.name),
        row(t('scan.file'), `${facts.format}, ${bytes(scan.file.size)}`),
        row(t('scan.triangles'), number(facts.triangles)),
        row(t('scan.size'), this.#unit || this.#value('scan', 'size_mm') ? millimetres(placed.size) : t('scan.size_unknown')),
        row(t('scan.time'), duration(Math.max(1, scan.ms / 1000)))),
      doubt.wide && warning(t('scan.too_wide', {window: millimetres(frame.window.slice(0, frame.round ? 1 : 2))})),
      facts.insideOut && doubt.mirrored && warning(t('scan.inside_out'))];
  }

  #upHint(): Children {
    const up = this.#scan?.read.facts.up;
    return el('p', {class: 'hint'}, t(up && !up.told && up.axis === this.#up ? 'scan.up_guess' : 'scan.up_hint'));
  }

  #unitChoice(follows: (() => void)[], host: (build: () => Children) => HTMLElement): HTMLElement {
    const name = newId('unit');
    const cards = units.map((unit) => {
      const input = el('input', {type: 'radio', name, value: unit, onchange: () => this.#change({units: unit, size_mm: 'auto'})});
      const size = el('span', {class: 'quiet small'}), verdict = el('span', {class: 'verdict small'});
      const card = el('label', {class: 'unit-card'}, el('span', {class: 'choice'}, input, t(`scan.unit_${unit}`)), size, verdict);
      follows.push(() => {
        input.checked = this.#unit === unit;
        const guess = this.#scan && sizesOf(this.#scan.read.facts).find((one) => one.unit === unit);
        const fits = guess ? likeHead(guess) : false;
        card.classList.toggle('fits', fits);
        size.textContent = guess ? guess.mm.some((mm) => mm >= 10_000) ? t('scan.huge') : `${guess.mm.map((mm) => number(mm, mm < 10 ? 1 : 0)).join(' × ')} mm` : '';
        replace(verdict, guess ? [fits && icon('check'), t(`scan.like_${guess.like}`)] : null);
      });
      return card;
    });
    return el('fieldset', null, el('legend', null, t('scan.unit')), el('p', {class: 'hint'}, t('scan.unit_hint')),
      el('div', {class: 'unit-cards'}, cards),
      host(() => {
        const read = this.#scan?.read;
        if (!read || typeof this.#value('scan', 'size_mm') === 'number') return null;
        const fitting = sizesOf(read.facts).filter(likeHead);
        const text = this.#unit ? !this.#suspicions(read).plausible && t('scan.unit_implausible')
          : fitting.length === 0 ? t('scan.unit_none') : t('scan.unit_choose');
        return text && warning(text, 'alert');
      }),
      this.#numberRow(follows, 'size_mm', t('scan.longest'), 10, 2000, 'mm', () => typeof this.#value('scan', 'size_mm') === 'number' || (this.#scan !== null && !unitOf(this.#scan.read.facts))));
  }

  #numberRow(follows: (() => void)[], key: string, label: string, min: number, max: number, unit: string, needed = (): boolean => true): HTMLElement {
    const id = `scan-section-${key}`;
    const field: NumberField = numberField({id, label, named: true, unit, min, max, change: (value) => { if (value !== null) this.#change({[key]: value}); }});
    const row = el('div', {class: 'field'}, el('label', {for: id}, label), field.element);
    follows.push(() => {
      row.hidden = !needed();
      const value = this.#value('scan', key);
      field.show(typeof value === 'number' ? value : unit === '°' ? 0 : null);
    });
    return row;
  }

  #trimRow(follows: (() => void)[]): HTMLElement {
    const row = this.#numberRow(follows, 'trim_mm', t('scan.trim'), 0, 2000, 'mm');
    const auto = el('input', {type: 'checkbox', onchange: () => this.#change({trim_mm: auto.checked ? 'auto' : Math.round(this.#trim ?? 30)})});
    const hint = el('p', {class: 'hint'});
    follows.push(() => {
      auto.checked = typeof this.#value('scan', 'trim_mm') !== 'number';
      row.hidden = auto.checked;
      hint.textContent = !auto.checked ? t('scan.trim_hint') : this.#trim === null ? t('scan.trim_auto_hint') : t('scan.trim_found', {trim: Math.round(this.#trim)});
    });
    return el('fieldset', null, el('legend', null, t('scan.cut')), el('label', {class: 'choice'}, auto, t('scan.trim_auto')), hint, row);
  }

  // The whole head from the front, beside the question where its left ear is: drawn without WebGL, at every width.
  #frontFigure(follows: (() => void)[]): HTMLElement {
    const image = el('img', {width: 240, height: 240}), plus = el('span', {'aria-hidden': 'true'}), minus = el('span', {'aria-hidden': 'true'});
    const words = el('figcaption', {class: 'small quiet'}), figure = el('figure', {class: 'scan-front'}, el('div', null, plus, image, minus), words);
    let drawn = '', timer = 0, of: ReadScan | null = null;
    onEnd(() => clearTimeout(timer));
    follows.push(() => {
      const read = this.#scan?.read ?? this.#mold, stands = this.#stands, left = this.#left;
      image.hidden = plus.hidden = minus.hidden = !read;
      words.textContent = t(this.#scan ? 'scan.front_whole' : read ? 'scan.front_mold' : 'scan.front_none');
      [plus.textContent, minus.textContent] = left === 'unknown' ? ['+x', '−x'] : left === 'minus_x' ? ['R', 'L'] : ['L', 'R'];
      image.alt = t('scan.front_alt', {left: plus.textContent, right: minus.textContent});
      const turn = this.#scan && stands ? stands.turn : [1, 0, 0, 0, 1, 0, 0, 0, 1];
      const cut = this.#scan && stands ? stands.size[2] - (stands.height - this.#plug) : 0, now = JSON.stringify([turn, cut]);
      if (!read || read === of && now === drawn) return;
      [drawn, of] = [now, read];
      clearTimeout(timer);
      timer = window.setTimeout(() => {
        const {width, height, pixels} = frontPicture(read.coarse ?? read.shown, turn, cut, 480), canvas = el('canvas', {width, height});
        canvas.getContext('2d')?.putImageData(new ImageData(pixels as Uint8ClampedArray<ArrayBuffer>, width, height), 0, 0);
        image.src = canvas.toDataURL();
        image.width = width / 2;
        image.height = height / 2;
        figure.dataset['drawn'] = now;
      }, 100);
    });
    return figure;
  }

  // Seen from the front, +x is on the left of the picture.
  #sides(follows: (() => void)[], host: (build: () => Children) => HTMLElement): HTMLElement {
    const answer = (value: 'minus_x' | 'plus_x' | 'unknown', text: string): HTMLElement => {
      const input = el('input', {type: 'radio', name: 'scan-left', value, onchange: () => {
        // Of a scan that only the service has seen, this page knows no axis to confirm.
        this.#change(value === 'unknown' || !this.#scan ? {left_side: value} : {left_side: value, front: this.#front, up: this.#up});
      }});
      follows.push(() => { input.checked = this.#left === value; });
      return el('label', {class: 'choice'}, input, text);
    };
    return el('fieldset', {class: 'sides'}, el('legend', null, t('scan.left')), el('p', {class: 'hint'}, t('scan.left_hint')),
      this.#frontFigure(follows),
      host(() => this.#scene && el('p', null, el('button', {type: 'button', id: 'scan-front-view', onclick: () => this.#scene?.viewer.setView('front')}, icon('view'), t('scan.left_view')))),
      answer('minus_x', t('scan.left_in_right')), answer('plus_x', t('scan.left_in_left')), answer('unknown', t('scan.left_unknown')),
      host(() => this.#left === 'plus_x'
        ? el('div', {class: 'notice', role: 'alert'}, icon('warning'), el('div', null, el('p', null, t('scan.mirror_warning')),
            el('button', {type: 'button', onclick: () => {
              this.#change({mirror: this.#mirror === 'yes' ? 'no' : 'yes'});
              this.#straighten();
            }}, t('scan.mirror_now'))))
        : this.#left === 'minus_x' ? el('p', {class: 'notice good'}, icon('check'), el('span', null, t('scan.left_confirmed'))) : null));
  }

  #select(follows: (() => void)[], key: string, label: string, hint: string, options: [string, string][]): HTMLElement {
    const id = `scan-section-${key}`;
    const box = el('select', {id, 'aria-describedby': hint && `${id}-hint`, onchange: () => this.#change({[key]: box.value})},
      options.map(([value, text]) => el('option', {value}, text)));
    follows.push(() => { box.value = String(this.#value('scan', key) ?? 'auto'); });
    return el('div', {class: 'field'}, el('label', {for: id}, label), hint && el('p', {class: 'hint', id: `${id}-hint`}, hint), box);
  }
}
customElements.define('vf-scan-section', ScanSection);
