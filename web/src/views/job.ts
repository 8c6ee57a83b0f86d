import {el, type Children} from '../dom';
import {t} from '../text';
import {View} from '../view';

class Job extends View {
  protected build(): Children {
    return [el('h1', null, t('shell.not_found')), el('p', null, t('shell.not_found_help'))];
  }
}
customElements.define('vf-job', Job);
