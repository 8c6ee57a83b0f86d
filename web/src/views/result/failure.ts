// A print that failed after its scan was read: the mold in the machine with the place where it failed, and the warnings.
import {el, replace, type Children} from '../../dom';
import {api} from '../../api/client';
import type {Job} from '../../api/types';
import {icon} from '../../parts/icon';
import {problemBox} from '../../parts/problem';
import {readScanFile} from '../../parts/reader';
import {warningsList} from '../../parts/warnings-list';
import type {LeftSide} from '../../scene/orbit';
import type {ScanScene} from '../../scene/scan';
import {standingOf, type Report} from '../../state/jobs';
import {number, t} from '../../text';

// `pictures` are shown where there is no 3D view.
export function failureView(job: Job, report: Report, pictures: HTMLElement, ends: (() => void)[]): Children {
  const place = report.problem?.place_mm, [x = '', y = '', z = ''] = place?.map((mm) => number(mm, 1)) ?? [];
  const host = el('div', {class: 'result-view'}, el('p', {class: 'quiet', role: 'status'}, t('result.loading_3d')));
  const ending = new AbortController(), {signal} = ending;
  let scene: ScanScene | null = null;
  ends.push(() => {
    ending.abort();
    scene?.viewer.dispose();
  });
  const flat = (): void => {
    scene = null;
    replace(host, pictures);
  };
  function show(mm: readonly number[]): void {
    scene?.mark(mm);
    host.scrollIntoView({block: 'nearest'});
    scene?.viewer.canvas.focus({preventScroll: true});
  }
  async function load(): Promise<void> {
    if (!job.artifacts.some((file) => file.name === 'mold.stl')) return flat();
    try {
      const [{scanScene, NoWebGl}, file] = await Promise.all([import('../../scene/scan'), api.artifact(job.id, 'mold.stl').then((answer) => answer.blob())]);
      const read = await readScanFile(new File([file], 'mold.stl'), () => {}, signal);
      if (signal.aborted) return;
      try {
        scene = scanScene(read, {label: t('job.mold_in_machine'), failed: flat});
      } catch (error) {
        if (error instanceof NoWebGl) return flat();
        throw error;
      }
      replace(host, scene.viewer.element);
      scene.update({...standingOf(read.facts, job.settings), ink: null, marks: [], left: job.settings['scan']?.['left_side'] as LeftSide});
      if (place) scene.mark(place);
    } catch (error) {
      if (!signal.aborted) replace(host, [problemBox(error, () => void load()), pictures]);
    }
  }
  void load();
  return [
    el('section', {class: 'card stack'}, el('h2', null, t('job.mold_in_machine')),
      place && el('p', {class: 'row'}, t('problem.where', {where: t('job.place_at', {x, y, z})}), el('button', {type: 'button', onclick: () => show(place)}, icon('view'), t('job.show_failure'))),
      host),
    el('section', {class: 'card'}, el('h2', null, t('job.warnings')), warningsList(report.warnings, show))];
}
