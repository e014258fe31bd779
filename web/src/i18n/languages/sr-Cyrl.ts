import { inCyrillic } from "../serbian_scripts";
import { marked } from "./sr-Latn";

export const texts = inCyrillic(marked);
