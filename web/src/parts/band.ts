// Who and what a print is for: the same words on every view and every picture.
import {el} from '../dom';
import type {Job, ListedJob} from '../api/types';
import type {Report} from '../state/jobs';
import {t} from '../text';

export const shortId = (id: string): string => id.slice(-8);

// What people call a job.
export const nameOf = (job: Pick<ListedJob, 'id' | 'reference'>): string =>
  job.reference || t('job.unnamed', {id: shortId(job.id)});

type Identified = Pick<Job, 'id' | 'kind' | 'reference' | 'settings' | 'inputs'>;
type Made = Pick<Report, 'label'> & {scan?: Pick<Report['scan'], 'mirrored'>};

interface Piece {
  name: string;
  text: string;
  doubtful?: boolean;  // shown with emphasis
}

// `report`: report.json, where there is one: it has the label that the print carries.
function pieces(job: Identified, report?: Made | null): Piece[] {
  const {scan = {}, pattern = {}} = job.settings;
  const side = String(scan['left_side'] ?? 'unknown');
  const known = side === 'minus_x' || side === 'plus_x';
  const all: Piece[] = [{name: t('job.reference'), text: job.reference || t('job.no_reference'), doubtful: !job.reference},
                        {name: t('job.id'), text: shortId(job.id)}];
  if (report?.label) all.push({name: t('job.label'), text: report.label});
  if (job.inputs['scan']) all.push({name: t('job.scan'), text: job.inputs['scan'].sha256.slice(0, 8)});
  all.push({name: t('job.side'), text: known ? t(`job.side_${side}`) : t('job.side_unknown'), doubtful: !known});
  if (report?.scan?.mirrored) all.push({name: t('job.mirrored'), text: t('job.mirrored_scan'), doubtful: true});
  if (job.kind === 'print')
    all.push({name: t('job.face'), text: pattern['inked_face'] === 'inner' ? t('job.face_inner') : t('job.face_outer')});
  return all;
}

// "CASE-7 · job 9v46mzm1 · print 1beb9f978cba · scan 26fba091 · ..."
export const identityOf = (job: Identified, report?: Made | null): string =>
  pieces(job, report).map((piece, at) => at === 0 ? piece.text : `${piece.name}: ${piece.text}`).join(' · ');

export function band(job: Identified, report?: Made | null): HTMLElement {
  return el('dl', {class: 'band', 'aria-label': t('job.identity')}, ...pieces(job, report).map((piece) =>
    el('div', piece.doubtful ? {class: 'doubtful'} : null, el('dt', null, piece.name), el('dd', null, piece.text))));
}
