// What the page knows: one immutable value. Each area has its own file with its type and its pure functions.
import {createStore} from './store';
import type {Session} from './api/types';
import {initialJobs, type JobsState} from './state/jobs';
import {emptyDraft, type DraftState} from './state/draft';
import {initialResult, type ResultState} from './state/result';
import {routeOf, type Route} from './route';

export interface State {
  route: Route;
  session: Session | null;  // null before the server has said who is signed in
  online: boolean;          // false while the server does not answer
  announcement: string;     // the line that screen readers speak
  jobs: JobsState;
  draft: DraftState;        // the print that is being prepared
  result: ResultState;      // the job that is shown
}

export const store = createStore<State>({
  route: routeOf(location.hash),
  session: null,
  online: true,
  announcement: '',
  jobs: initialJobs,
  draft: emptyDraft(Math.random().toString(36).slice(2)),
  result: initialResult,
});

export const setJobs = (change: Partial<JobsState>): void => store.set(({jobs}) => ({jobs: {...jobs, ...change}}));

// Has screen readers speak a line, also when it is the same as before.
export function announce(text: string): void {
  store.set({announcement: ''});
  store.set({announcement: text});
}
