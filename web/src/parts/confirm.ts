// Asks before what cannot be undone. The focus returns to the button that asked.
import {el, newId} from '../dom';
import {t} from '../text';
import {icon, type IconName} from './icon';

export interface Question {
  title: string;
  text: string;
  action: string;  // what the button does, in words
  icon: IconName;
}

export function confirm(question: Question): Promise<boolean> {
  const title = newId('dialog'), text = newId('dialog');
  const opener = document.activeElement;
  const cancel = el('button', {type: 'submit', value: 'no', autofocus: true}, t('shell.cancel'));
  const dialog = el('dialog', {'aria-labelledby': title, 'aria-describedby': text},
    el('form', {method: 'dialog', class: 'stack'},
      el('h2', {id: title}, question.title),
      el('p', {id: text}, question.text),
      el('div', {class: 'row end'}, cancel,
        el('button', {type: 'submit', value: 'yes', class: 'danger'}, icon(question.icon), question.action))));
  return new Promise((answer) => {
    dialog.addEventListener('close', () => {
      dialog.remove();
      if (opener instanceof HTMLElement && opener.isConnected) opener.focus({preventScroll: true});
      answer(dialog.returnValue === 'yes');
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}
