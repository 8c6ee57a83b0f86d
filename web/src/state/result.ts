// The job that is shown.
export interface ResultState {}

export const initialResult: ResultState = {};
