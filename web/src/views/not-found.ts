import {el, type Children} from '../dom';
import {icon} from '../parts/icon';
import {setTitle} from '../parts/progress';
import {toJobs} from '../route';
import {t} from '../text';
import {View} from '../view';

class NotFound extends View {
  protected build(): Children {
    setTitle(t('shell.not_found'));
    return el('div', {class: 'card empty'}, icon('search'), el('h1', null, t('shell.not_found')),
      el('p', null, t('shell.not_found_help')), el('p', null, el('a', {class: 'button', href: toJobs()}, t('shell.jobs'))));
  }
}
customElements.define('vf-not-found', NotFound);
