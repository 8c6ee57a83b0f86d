// Tokens: who may do what. The secret of a new one is shown once, and so is a link that signs in with one.
import {api} from '../../api/client';
import type {Scope, TokenInfo} from '../../api/types';
import {el, newId, replace, type Children} from '../../dom';
import {confirm, openDialog} from '../../parts/confirm';
import {facts} from '../../parts/facts';
import {icon} from '../../parts/icon';
import {problemBox} from '../../parts/problem';
import {announce, store} from '../../state';
import {t, when} from '../../text';
import {loaded} from './loaded';

const roles = {print: ['submit', 'read'], look: ['read'], work: ['work'], admin: ['admin']} satisfies Record<string, Scope[]>;
type Role = keyof typeof roles;
const roleNames: Role[] = ['print', 'look', 'work', 'admin'];
const lifetimes = [7, 30, 90, 365, 0] as const;  // days; 0: for ever
const ownerPattern = /^[a-z0-9-]{1,32}$/;

const usable = (token: TokenInfo): boolean =>
  token.revoked === null && (token.expires === null || new Date(token.expires).getTime() > Date.now());

const roleOf = (token: TokenInfo): string => {
  const role = roleNames.find((name) => [...roles[name]].sort().join() === [...token.scopes].sort().join());
  return role ? t(`admin.role_${role}`) : token.scopes.join(', ');
};

function showOnce(kind: 'secret' | 'link', owner: string, value: string): void {
  const title = newId('secret'), field = newId('secret');
  const input = el('input', {id: field, readonly: true, value, class: 'secret', spellcheck: 'false'});
  void openDialog({'aria-labelledby': title},
    el('h2', {id: title}, t(`admin.${kind}_title`, {owner})),
    el('p', null, t(`admin.${kind}_once`)),
    el('div', null, el('label', {for: field}, t(`admin.${kind}`)), input),
    el('div', {class: 'row'},
      el('button', {type: 'button', class: 'primary', onclick: () => {
        input.select();
        void navigator.clipboard.writeText(value).then(() => announce(t('problem.copied')));
      }}, icon('copy'), t(`admin.${kind}_copy`)),
      el('button', {type: 'submit'}, t('shell.close'))));
}

function creation(created: () => void): HTMLElement {
  const id = newId('owner');
  const owner = el('input', {id, autocomplete: 'off', autocapitalize: 'none', spellcheck: 'false', maxlength: 32,
                             'aria-describedby': `${id}-hint ${id}-fault`});
  const fault = el('p', {class: 'fault', id: `${id}-fault`});
  const days = el('select', {id: `${id}-days`}, lifetimes.map((count) => el('option', {value: count, selected: count === 90},
    count === 0 ? t('admin.days_never') : t('admin.days', {count}))));
  const role = (name: Role): HTMLElement => {
    const radio = `${id}-${name}`;
    return el('div', {class: 'role'},
      el('label', {class: 'choice', for: radio},
        el('input', {type: 'radio', name: 'role', id: radio, value: name, checked: name === 'print', 'aria-describedby': `${radio}-hint`}),
        t(`admin.role_${name}`)),
      el('p', {class: 'hint', id: `${radio}-hint`}, t(`admin.role_hint_${name}`)));
  };
  const problem = el('div');
  const send = async (): Promise<void> => {
    replace(problem, null);
    const good = ownerPattern.test(owner.value);
    fault.textContent = good ? '' : t('admin.owner_fault');
    owner.setAttribute('aria-invalid', String(!good));
    if (!good) {
      owner.focus();
      return;
    }
    const chosen = roleNames.find((name) => name === new FormData(form).get('role')) ?? 'print';
    try {
      const made = await api.createToken({owner: owner.value, scopes: roles[chosen],
                                          ...(days.value !== '0' && {days: Number(days.value)})});
      form.reset();
      showOnce('secret', made.owner, made.token);
      created();
    } catch (error) {
      replace(problem, problemBox(error));
    }
  };
  const form = el('form', {class: 'card', novalidate: true, onsubmit: (event) => {
    event.preventDefault();
    void send();
  }},
    el('h2', null, t('admin.token_new')),
    problem,
    el('div', {class: 'field'}, el('label', {for: id}, t('admin.owner')),
       el('p', {class: 'hint', id: `${id}-hint`}, t('admin.owner_hint')), fault, owner),
    el('fieldset', null, el('legend', null, t('admin.roles')), el('div', {class: 'roles'}, roleNames.map(role))),
    el('div', {class: 'field'}, el('label', {for: `${id}-days`}, t('admin.lifetime')), days),
    el('p', null, el('button', {type: 'submit', class: 'primary'}, icon('add'), t('admin.token_create'))));
  return form;
}

function entry(token: TokenInfo, changed: () => void): HTMLElement {
  const own = store.get().session?.token === token.id;
  const revoke = async (): Promise<void> => {
    if (!(await confirm({title: t('admin.revoke_title', {owner: token.owner}),
                         text: own ? t('admin.revoke_own') : t('admin.revoke_text'), action: t('admin.revoke'), icon: 'cancel'})))
      return;
    try {
      await api.revokeToken(token.id);
      announce(t('admin.revoked_said', {owner: token.owner}));
      changed();
    } catch (error) {
      replace(problem, problemBox(error));
    }
  };
  const link = async (): Promise<void> => {
    replace(problem, null);
    try {
      showOnce('link', token.owner, location.origin + (await api.createSignInLink(token.id)).path);
    } catch (error) {
      replace(problem, problemBox(error));
    }
  };
  const problem = el('div');
  return el('li', {class: 'card entry'},
    el('div', null, el('h3', null, token.owner, own && el('span', {class: 'state'}, t('admin.own'))),
       el('p', null, roleOf(token)), problem),
    el('div', {class: 'small'}, facts(
      [t('admin.token_id'), el('code', null, token.id)],
      [t('admin.created'), when(token.created)],
      token.revoked ? [t('admin.revoked'), when(token.revoked)]
                    : [t('admin.expires'), token.expires ? when(token.expires) : t('admin.days_never')])),
    usable(token) && el('div', {class: 'row'},
      !token.scopes.includes('work') && el('button', {type: 'button', onclick: () => void link(),
        'aria-label': t('admin.link_of', {owner: token.owner, id: token.id})}, t('admin.link')),
      el('button', {type: 'button', class: 'danger', onclick: () => void revoke(),
                    'aria-label': t('admin.revoke_of', {owner: token.owner, id: token.id})}, t('admin.revoke'))));
}

export function tokens(): Children {
  const list = loaded(api.tokens, ({tokens: all}) => {
    const newest = [...all].reverse();
    const ended = newest.filter((token) => !usable(token));
    const entries = (some: TokenInfo[]): HTMLElement =>
      el('ul', {class: 'entries'}, some.map((token) => entry(token, () => void list.read())));
    return [
      el('h2', null, t('admin.tokens_usable')),
      entries(newest.filter(usable)),
      ended.length > 0 && el('details', null, el('summary', null, t('admin.tokens_ended', {count: ended.length})), entries(ended)),
    ];
  });
  return [el('p', {class: 'quiet'}, t('admin.tokens_intro')), creation(() => void list.read()), list.host];
}
