// Fields of the draft's settings, and the way to each of them.
import type {SettingsSchema} from '../../api/types';
import {settingsForm, type SettingsForm} from '../../parts/settings-form';
import {follow, onEnd} from '../../view';
import {draft, setFault, setSetting} from './work';

const forms = new Set<SettingsForm>();
let openAll = (): SettingsForm | null => null;

// `only`: these settings; without it all of them, with a search.
export function draftFields(schema: SettingsSchema, prefix: string, only?: readonly string[]): SettingsForm {
  const form = settingsForm({
    schema, prefix, ...(only && {only}), settings: () => draft().form.settings, change: setSetting, fault: setFault});
  forms.add(form);
  return form;
}

// Once for the page: every field follows the draft.
export function followDraft(open: () => SettingsForm | null): void {
  openAll = open;
  follow(({draft: {form, faults, problem}}) => [form.settings, faults, problem] as const, ([, faults, problem]) => {
    for (const form of forms) form.show(faults, problem);
  });
  onEnd(() => {
    forms.clear();
    openAll = () => null;
  });
}

// Goes to the field of a setting; false if it has no field.
export function focusSetting(id: string): boolean {
  const ofScan = document.getElementById(`scan-section-${id.split('.')[1] ?? ''}`);  // the fields of new/scan.ts
  if (id.startsWith('scan.') && ofScan?.offsetParent) {
    ofScan.scrollIntoView({block: 'center'});
    ofScan.focus({preventScroll: true});
    return true;
  }
  for (const form of forms) if (form.element.isConnected && form.element.offsetParent && form.focus(id)) return true;
  return openAll()?.focus(id) ?? false;
}
