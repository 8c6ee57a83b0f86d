// Administration: the state of the service, tokens, profiles.
import {el, type Children} from '../dom';
import {icon} from '../parts/icon';
import {toAdmin} from '../route';
import {store} from '../state';
import {t} from '../text';
import {live, View} from '../view';
import {profiles} from './admin/profiles';
import {system} from './admin/system';
import {tokens} from './admin/tokens';

const pages = {system, tokens, profiles};
type Page = keyof typeof pages;
const names: Page[] = ['system', 'tokens', 'profiles'];

class Admin extends View {
  protected build(): Children {
    const {route} = store.get();
    const asked = route.view === 'admin' ? route.page : '';
    const page = names.find((name) => name === asked) ?? 'system';
    return [
      el('h1', null, t('admin.title')),
      live((state) => state.session && state.session.scopes.includes('admin'), (allowed) => allowed === null ? null : allowed ? [
        el('nav', {class: 'tabs', 'aria-label': t('admin.title')}, el('ul', null, names.map((name) =>
          el('li', null, el('a', {href: toAdmin(name), 'aria-current': name === page && 'page'}, t(`admin.page_${name}`)))))),
        pages[page](),
      ] : el('p', {class: 'notice'}, icon('warning'), el('span', null, t('admin.not_allowed')))),
    ];
  }
}
customElements.define('vf-admin', Admin);
