interface Question {
  /** What will be done, also the button's text. */
  title: string;
  explained: string;
  answer(sure: boolean): void;
}

/** Asks before something that cannot be taken back. The dialog is in App. */
class Sure {
  question = $state.raw<Question | null>(null);

  /** Whether the person is sure. A question that is still open is answered with no. */
  ask(title: string, explained: string): Promise<boolean> {
    this.question?.answer(false);
    return new Promise((resolve) => {
      this.question = {
        title,
        explained,
        answer: (sure) => {
          this.question = null;
          resolve(sure);
        },
      };
    });
  }
}

export const sure = new Sure();
