// Elements without HTML text: nothing that a user typed is ever parsed.

export type Child = Node | string | null | undefined | false;
export type Children = Child | readonly Children[];

type Handlers = {[K in keyof HTMLElementEventMap as `on${K}`]?: (event: HTMLElementEventMap[K]) => void};
type Value = string | number | boolean | null | undefined;
// Attributes by their HTML names; a name that begins with "on" takes a listener. true sets an attribute without a value;
// false, null and undefined leave it out.
export type Props = Handlers & {[name: string]: Value | ((event: never) => void)};

export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K, props?: Props | null, ...children: Children[]): HTMLElementTagNameMap[K];
export function el(tag: string, props?: Props | null, ...children: Children[]): HTMLElement;
export function el(tag: string, props?: Props | null, ...children: Children[]): HTMLElement {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(props ?? {})) {
    if (typeof value === 'function') element.addEventListener(name.slice(2), value as EventListener);
    else if (value === true) element.setAttribute(name, '');
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, String(value));
  }
  append(element, children);
  return element;
}

export function append(parent: Node, children: Children): void {
  if (Array.isArray(children)) {
    for (const child of children) append(parent, child);
  } else if (children !== null && children !== undefined && children !== false) {
    parent.appendChild(typeof children === 'string' ? document.createTextNode(children) : (children as Node));
  }
}

// Replaces the children. Focus returns to the element with the id that had it.
export function replace(parent: Element, children: Children): void {
  const focused = parent.contains(document.activeElement) ? document.activeElement?.id : undefined;
  const fragment = document.createDocumentFragment();
  append(fragment, children);
  parent.replaceChildren(fragment);
  if (focused) document.getElementById(focused)?.focus({preventScroll: true});
}

export function svg(tag: string, props: Record<string, string | number>, ...children: (Node | string)[]): SVGElement {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(props)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

let lastId = 0;
// An id for an element that a label or a description refers to.
export const newId = (prefix: string): string => `${prefix}-${++lastId}`;

// Scrolls to a heading and reads on from there.
export function jumpTo(id: string): void {
  const heading = document.getElementById(id);
  heading?.scrollIntoView();
  heading?.focus({preventScroll: true});
}
