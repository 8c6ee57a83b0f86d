// The views by their address. The part behind "?" belongs to the view: a link restores what it showed.

export type Route =
  | {view: 'jobs'; query: string}
  | {view: 'new'; query: string}
  | {view: 'job'; id: string; query: string}
  | {view: 'compare'; a: string; b: string; query: string}
  | {view: 'admin'; page: string; query: string}
  | {view: 'help'; page: string; query: string}
  | {view: 'none'; query: string};

export function routeOf(hash: string): Route {
  const [path = '', query = ''] = hash.replace(/^#\/?/, '').split('?', 2);
  const [view, a = '', b = ''] = path.split('/').map(decodeURIComponent);
  switch (view) {
    case '':
    case 'jobs':
      return a ? {view: 'job', id: a, query} : {view: 'jobs', query};
    case 'new': return {view: 'new', query};
    case 'compare': return a && b ? {view: 'compare', a, b, query} : {view: 'none', query};
    case 'admin': return {view: 'admin', page: a, query};
    case 'help': return {view: 'help', page: a, query};
    default: return {view: 'none', query};
  }
}

export const toJobs = (): string => '#/jobs';
export const toNew = (query = ''): string => `#/new${query && '?' + query}`;
export const toJob = (id: string, query = ''): string => `#/jobs/${encodeURIComponent(id)}${query && '?' + query}`;
export const toCompare = (a: string, b: string): string => `#/compare/${encodeURIComponent(a)}/${encodeURIComponent(b)}`;
export const toHelp = (page = ''): string => `#/help${page && '/' + page}`;
export const toAdmin = (page = ''): string => `#/admin${page && '/' + page}`;
