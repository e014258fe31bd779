// The parts of languages/en.ts that scripts/first_texts.js makes.
declare module "*/en.ts?first" {
  export const texts: import("./catalogue").Catalogue;
}
declare module "*/en.ts?rest" {
  export const texts: import("./catalogue").Catalogue;
}
declare module "*/en.ts?lessons" {
  export const texts: import("./catalogue").Catalogue;
}
// From core/types/refusals.json, by scripts/refusals.js.
declare module "refusals:*" {
  type Reason = import("../contract/types").Schemas["RefusalReason"];
  export const texts: Record<`refused_${Reason}`, import("./catalogue").Text>;
}
