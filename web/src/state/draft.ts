// The print that is being prepared.
export interface DraftState {}

export const initialDraft: DraftState = {};
