// Questions in a dialog. The focus returns to the button that asked.
import {el, newId, type Children, type Props} from '../dom';
import {t} from '../text';
import {icon, type IconName} from './icon';

// Shows a dialog with a form. Returns the value of the button that closes it; empty after Escape.
export function openDialog(props: Props, ...content: Children[]): Promise<string> {
  const opener = document.activeElement;
  const dialog = el('dialog', props, el('form', {method: 'dialog', class: 'stack'}, content));
  return new Promise((answer) => {
    dialog.addEventListener('close', () => {
      dialog.remove();
      if (opener instanceof HTMLElement && opener.isConnected) opener.focus({preventScroll: true});
      answer(dialog.returnValue);
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}

export interface Question {
  title: string;
  text: string;
  action: string;  // what the button does, in words
  icon: IconName;
}

// Asks before what cannot be undone.
export async function confirm(question: Question): Promise<boolean> {
  const title = newId('dialog'), text = newId('dialog');
  return await openDialog({'aria-labelledby': title, 'aria-describedby': text},
    el('h2', {id: title}, question.title),
    el('p', {id: text}, question.text),
    el('div', {class: 'row end'},
      el('button', {type: 'submit', value: 'no', autofocus: true}, t('shell.cancel')),
      el('button', {type: 'submit', value: 'yes', class: 'danger'}, icon(question.icon), question.action))) === 'yes';
}
