// Profiles: settings under a name. The query says which one is edited or copied: ?edit=NAME, ?copy=NAME, ?new=.
import {api} from '../../api/client';
import type {Profile, Settings, SettingsSchema} from '../../api/types';
import {el, newId, replace, type Children} from '../../dom';
import {confirm} from '../../parts/confirm';
import {icon} from '../../parts/icon';
import {problemBox} from '../../parts/problem';
import {settingsForm} from '../../parts/settings-form';
import {toAdmin} from '../../route';
import {announce} from '../../state';
import {withSetting} from '../../state/draft';
import {t, when} from '../../text';
import {live} from '../../view';
import {loaded} from './loaded';

const namePattern = /^[a-z0-9-]{1,64}$/;
const to = (what: string, name = ''): string => `${toAdmin('profiles')}?${new URLSearchParams({[what]: name})}`;

function entry({name, settings, changed, default: isDefault}: Profile, read: () => void): HTMLElement {
  const problem = el('div');
  const change = async (act: () => Promise<unknown>, said: string): Promise<void> => {
    try {
      await act();
      announce(said);
      read();
    } catch (error) {
      replace(problem, problemBox(error));
    }
  };
  const remove = async (): Promise<void> => {
    if (!(await confirm({title: t('admin.profile_delete_title', {name}), text: t('admin.profile_delete_text'),
                         action: t('admin.profile_delete'), icon: 'delete'})))
      return;
    await change(() => api.removeProfile(name), t('admin.profile_deleted', {name}));
  };
  const count = Object.values(settings).reduce((sum, group) => sum + Object.keys(group).length, 0);
  return el('li', {class: 'card entry'},
    el('div', null, el('h2', null, name, isDefault && el('span', {class: 'kind quiet'}, ' ', t('admin.profile_default'))), problem),
    el('p', {class: 'quiet'}, t('admin.profile_settings', {count, time: when(changed)})),
    el('div', {class: 'row'},
      el('a', {class: 'button', href: to('edit', name), 'aria-label': t('admin.profile_edit_of', {name})}, t('admin.profile_edit')),
      el('a', {class: 'button', href: to('copy', name), 'aria-label': t('admin.profile_copy_of', {name})}, t('admin.profile_copy')),
      el('button', {type: 'button', 'aria-label': t(isDefault ? 'admin.profile_unset_of' : 'admin.profile_set_of', {name}),
                    onclick: () => void change(() => api.setDefaultProfile(name, !isDefault),
                                               t(isDefault ? 'admin.profile_unset_done' : 'admin.profile_set_done', {name}))},
         t(isDefault ? 'admin.profile_unset' : 'admin.profile_set')),
      el('button', {type: 'button', class: 'danger', 'aria-label': t('admin.profile_delete_of', {name}),
                    onclick: () => void remove()}, t('admin.profile_delete'))));
}

function all(): Children {
  const list = loaded(api.profiles, ({profiles: found}) => found.length === 0
    ? el('p', {class: 'card empty'}, t('admin.profiles_none'))
    : el('ul', {class: 'entries'}, found.map((profile) => entry(profile, () => void list.read()))));
  return [
    el('p', {class: 'quiet'}, t('admin.profiles_intro')),
    el('p', null, el('a', {class: 'button primary', href: to('new')}, icon('add'), t('admin.profile_new'))),
    list.host];
}

// `etag`: of the profile that is edited; undefined for a new one.
function editor(schema: SettingsSchema, title: string, first: {name: string; settings: Settings; etag?: string}): Children {
  let {settings} = first;
  const faults: Record<string, string> = {};
  const id = newId('profile');
  const isNew = first.etag === undefined;
  const name = el('input', {id, value: first.name, readonly: !isNew, autocomplete: 'off', autocapitalize: 'none', spellcheck: 'false',
                            maxlength: 64, 'aria-describedby': `${id}-hint ${id}-fault`});
  const nameFault = el('p', {class: 'fault', id: `${id}-fault`});
  const problem = el('div');
  const fields = settingsForm({
    schema, prefix: id, settings: () => settings,
    change(setting, value) {
      settings = withSetting(settings, setting, value);
      fields.show(faults);
    },
    fault(setting, text) {
      if (text) faults[setting] = text;
      else delete faults[setting];
    }});
  const save = async (): Promise<void> => {
    const good = namePattern.test(name.value);
    nameFault.textContent = good ? '' : t('admin.profile_name_fault');
    name.setAttribute('aria-invalid', String(!good));
    const [wrong] = Object.keys(faults);
    replace(problem, wrong && el('p', {class: 'notice', role: 'alert'}, icon('warning'), el('span', null, t('admin.profile_fix'))));
    if (!good) name.focus();
    else if (wrong) fields.focus(wrong);
    if (!good || wrong) return;
    try {
      await api.putProfile(name.value, settings, isNew ? {'If-None-Match': '*'} : {'If-Match': first.etag ?? ''});
      announce(t('admin.profile_saved', {name: name.value}));
      location.hash = toAdmin('profiles');
    } catch (error) {
      const box = problemBox(error);
      replace(problem, box);
      box.querySelector('h2')?.focus();
    }
  };
  return el('form', {class: 'card', novalidate: true, onsubmit: (event) => {
    event.preventDefault();
    void save();
  }},
    el('h2', null, title),
    problem,
    el('div', {class: 'field'}, el('label', {for: id}, t('admin.profile_name')),
       el('p', {class: 'hint', id: `${id}-hint`}, t('admin.profile_name_hint')), nameFault, name),
    el('h3', null, t('admin.profile_fields')),
    fields.element,
    el('p', {class: 'row save'}, el('button', {type: 'submit', class: 'primary'}, icon('check'), t('admin.profile_save')),
       el('a', {class: 'button', href: toAdmin('profiles')}, t('shell.cancel'))));
}

function one(what: string, name: string): Children {
  const {host} = loaded(async () => {
    const [schema, read] = await Promise.all([api.schema(), name === '' ? null : api.profile(name)]);
    return {schema, read};
  }, ({schema, read}) => read === null
    ? editor(schema, t('admin.profile_title_new'), {name: '', settings: {}})
    : what === 'copy'
    ? editor(schema, t('admin.profile_title_copy', {name}), {name: `${name}-2`.slice(0, 64), settings: read.profile.settings})
    : editor(schema, t('admin.profile_title_edit', {name}), {name, settings: read.profile.settings, etag: read.etag}));
  return [el('p', null, el('a', {href: toAdmin('profiles')}, icon('back'), ' ', t('admin.profile_back'))), host];
}

export function profiles(): Children {
  return live((state) => state.route.query, (query) => {
    const asked = [...new URLSearchParams(query)][0];
    return asked ? one(asked[0], asked[1]) : all();
  });
}
