// Starts the application: language, session, then the view of the address.
import {api, onSignedOut, Problem} from './api/client';
import type {Session} from './api/types';
import {routeOf} from './route';
import {store} from './state';
import {restored, storedUnder} from './state/draft';
import {claim, placeOf, wipe} from './state/person';
import {chosenLanguage, loadLanguage} from './text';
import {applyTheme} from './parts/theme';
import {startShell} from './views/shell';

// Tells the other tabs of this browser who is signed in; null: nobody any more.
const persons = new BroadcastChannel('vacuform-session');
let left = false;

// Removes what the person prepared, here and in the other tabs. `to`: where to go; empty: nowhere yet.
function leave(to: string, tell: boolean): void {
  if (left) return;
  left = true;
  const token = store.get().session?.token ?? '';
  wipe(sessionStorage, to === '/sign-in' ? token : '', location.hash);
  if (tell) persons.postMessage({token: null});
  history.replaceState(null, '', '/');
  if (!to) return;
  document.body.replaceChildren();
  location.replace(to);
}
persons.onmessage = ({data}: MessageEvent<{token: string | null}>) => {
  const mine = store.get().session?.token;
  if (mine && data.token !== mine) leave(data.token === null ? '/sign-in' : '/', false);
};
// The cache of the browser keeps whole pages for "Back": neither their content nor a page that was left is shown again.
addEventListener('pagehide', () => { if (left) document.body.replaceChildren(); });
addEventListener('pageshow', (event) => { if (event.persisted) location.reload(); });

applyTheme();
await loadLanguage(chosenLanguage());
onSignedOut(() => leave('/sign-in', true));
window.addEventListener('hashchange', () => store.set({route: routeOf(location.hash)}));
startShell(document.body, () => leave('', true));

// From now on the page shows what belongs to this person.
function begin(session: Session): void {
  claim(sessionStorage, session.token);
  persons.postMessage({token: session.token});
  const place = placeOf(sessionStorage);
  if (place && !location.hash) history.replaceState(null, '', place);
  store.set({session, online: true, route: routeOf(location.hash),
             draft: restored(sessionStorage.getItem(storedUnder), store.get().draft.tab)});
}

async function readSession(): Promise<void> {
  try {
    const session = await api.session(), known = store.get().session;
    if (known && known.token !== session.token) leave('/', true);
    else if (known) store.set({session});
    else begin(session);
  } catch (error) {
    if (!(error instanceof Problem) || error.status === 401) return;
    if (store.get().session) return;
    store.set({online: error.status !== 0});
    setTimeout(() => void readSession(), 5000);
  }
}
// Somebody else may have signed in while nobody looked at this tab.
document.addEventListener('visibilitychange', () => { if (!document.hidden && store.get().session) void readSession(); });
await readSession();
