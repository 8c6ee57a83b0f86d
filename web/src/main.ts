// Starts the application: language, session, then the view of the address.
import {api, onSignedOut, Problem} from './api/client';
import {routeOf} from './route';
import {store} from './state';
import {chosenLanguage, loadLanguage} from './text';
import {applyTheme} from './parts/theme';
import {startShell} from './views/shell';

const keptPlace = 'vacuform.place';

applyTheme();
await loadLanguage(chosenLanguage());
onSignedOut(() => {
  sessionStorage.setItem(keptPlace, location.hash);
  location.assign('/sign-in');
});
const place = sessionStorage.getItem(keptPlace);
sessionStorage.removeItem(keptPlace);
if (place && !location.hash) location.replace(place);
window.addEventListener('hashchange', () => store.set({route: routeOf(location.hash)}));
store.set({route: routeOf(location.hash)});
startShell(document.body);

async function readSession(): Promise<void> {
  try {
    store.set({session: await api.session(), online: true});
  } catch (error) {
    if (!(error instanceof Problem) || error.status === 401) return;
    store.set({online: error.status !== 0});
    setTimeout(() => void readSession(), 5000);
  }
}
await readSession();
