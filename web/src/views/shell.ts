// The frame around every view: menu, state of the session, the place where the view stands.
import {el, type Children} from '../dom';
import {icon, type IconName} from '../parts/icon';
import {api} from '../api/client';
import {applyTheme, currentTheme, themes} from '../parts/theme';
import {toAdmin, toHelp, toJobs, toNew, type Route} from '../route';
import {store} from '../state';
import {chooseLanguage, currentLanguage, languages, t} from '../text';
import {follow, live, View} from '../view';
import './admin';
import './compare';
import './help';
import './job';
import './jobs';
import './new-print';
import './not-found';

const languageNames = {en: 'English', de: 'Deutsch'};

function menuLink(href: string, name: IconName, text: string, current: boolean): HTMLElement {
  return el('li', null, el('a', {href, 'aria-current': current && 'page'}, icon(name), el('span', null, text)));
}

function menu(view: Route['view'], mayAdminister: boolean): HTMLElement {
  return el('nav', {'aria-label': t('shell.main_menu')}, el('ul', null,
    menuLink(toJobs(), 'pattern', t('shell.jobs'), view === 'jobs' || view === 'job' || view === 'compare'),
    menuLink(toNew(), 'add', t('shell.new'), view === 'new'),
    menuLink(toHelp(), 'help', t('shell.help'), view === 'help'),
    mayAdminister && menuLink(toAdmin(), 'settings', t('shell.admin'), view === 'admin')));
}

function choices(owner: string | undefined, signOut: () => void): HTMLElement {
  const language = el('select', {id: 'language', onchange: () => chooseLanguage(
                                   languages.find((l) => l === language.value) ?? 'en')},
    ...languages.map((l) => el('option', {value: l, lang: l, selected: l === currentLanguage()}, languageNames[l])));
  const theme = el('select', {id: 'theme', onchange: () => applyTheme(
                                themes.find((name) => name === theme.value) ?? 'system')},
    ...themes.map((name) => el('option', {value: name, selected: name === currentTheme()}, t(`shell.theme_${name}`))));
  return el('details', {class: 'menu'},
    el('summary', null, icon('user'), el('span', null, owner ?? '')),
    el('div', {class: 'menu-box'},
      owner && el('p', {class: 'quiet small'}, t('shell.signed_in_as', {owner})),
      el('label', {for: 'language'}, t('shell.language')), language,
      el('label', {for: 'theme'}, t('shell.theme')), theme,
      el('form', {method: 'post', action: '/sign-out', onsubmit: signOut}, el('button', {type: 'submit'}, t('shell.sign_out')))));
}

class Shell extends View {
  signOut = (): void => {};

  protected build(): Children {
    const main = el('main', {id: 'main', tabindex: -1});
    const status = el('p', {class: 'hidden', role: 'status', id: 'status'});
    warnBeforeTheEnd();
    follow((state) => state.announcement, (text) => { status.textContent = text; });
    let shown = '';
    // A view may show what the person prepared: none before the server has said who it is.
    follow((state) => [state.route, state.session !== null] as const, ([route, known]) => {
      if (!known) return;
      const tag = `vf-${route.view === 'none' ? 'not-found' : route.view === 'new' ? 'new-print' : route.view}`;
      const place = JSON.stringify({...route, query: ''});
      if (place === shown) return;  // the query belongs to the view
      const first = shown === '';
      shown = place;
      main.replaceChildren(document.createElement(tag));
      if (!first) main.focus();
      scrollTo(0, 0);
    });
    const offline = live((state) => state.online, (online) =>
      !online && el('p', {class: 'notice', role: 'alert'}, icon('warning'), t('problem.no_server'), ' ',
                    t('problem.no_server_fix')));
    return [
      el('a', {class: 'skip', href: '#main', onclick: (event: Event) => { event.preventDefault(); main.focus(); }},
         t('shell.skip')),
      el('header', {class: 'bar'},
        el('a', {class: 'brand', href: toJobs()}, t('shell.name')),
        live((state) => [state.route.view, state.session?.scopes.includes('admin') ?? false] as const,
             ([view, admin]) => menu(view, admin)),
        live((state) => state.session?.owner, (owner) => choices(owner, () => this.signOut()))),
      offline, main, status,
      el('footer', null, el('span', null, t('shell.not_a_device')), el('a', {href: '/jobs'}, t('shell.plain')),
         el('a', {href: '/api/v1/openapi.yaml'}, t('shell.api'))),
    ];
  }
}
customElements.define('vf-shell', Shell);

// `signOut`: called before the person signs out.
export function startShell(body: HTMLElement, signOut: () => void): void {
  const shell = document.createElement('vf-shell') as Shell;
  shell.signOut = signOut;
  body.replaceChildren(shell);
}

// Two minutes before the session ends, the person is told. At its end the server is asked, and its answer ends the page.
function warnBeforeTheEnd(): void {
  let warning = 0, end = 0;
  follow((state) => state.session?.session_ends, (ends) => {
    clearTimeout(warning);
    clearTimeout(end);
    if (!ends) return;
    const left = new Date(ends).getTime() - Date.now();
    if (left >= 2 ** 31) return;
    warning = window.setTimeout(() => store.set({announcement: t('shell.session_ends')}), left - 120_000);
    end = window.setTimeout(() => void api.session().catch(() => {}), left + 1000);
  });
}
