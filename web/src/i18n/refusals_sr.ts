/**
 * Why the server refuses something, by the `reason` that it sends; the READMEs of server/run and
 * server/auth list the reasons. In English the server's own sentence is shown.
 */
export const refusalsSr: Record<string, string> = {
  refused_no_simulator: "Ovaj server nema simulatora stola {bench}; navedite drugi sto ili uređaj.",
  refused_rig_needs_session:
    "Za uređaj {rig} potreban je termin: stanite u red ili ga rezervišite.",
  refused_rig_just_found:
    "Uređaj {rig} je upravo pronađen i još nije proveren; pokušajte za minut.",
  refused_rig_elsewhere:
    "Uređaj {rig} prelazi na drugi server laboratorije ({member}); pokušajte za nekoliko sekundi.",
  refused_no_rig: "Uređaj {rig} ne postoji.",
  refused_rig_away: "Server uređaja {rig} ne odgovara; pokušajte za nekoliko sekundi.",
  refused_rig_in_use: "Uređaj {rig} je zauzet; pokušajte uskoro.",
  refused_simulators_in_use: "Svi simulatori su zauzeti; pokušajte uskoro.",
  refused_held_elsewhere: "Uređaj {rig} sada drži druga laboratorija; sačekajte da ga oslobodi.",
  refused_no_key:
    "Ključ uređaja {rig} nije na ovom serveru: operater treba da prekopira njegovu datoteku `.key` od agenta.",
  refused_other_key:
    "Poruke uređaja {rig} nisu načinjene ključem koji je na ovom serveru: operater treba ponovo da prekopira datoteku `.key` od agenta.",
  refused_other_protocol:
    "Agent uređaja {rig} i ovaj server su različitih verzija i ne razumeju se: operater treba da osveži stariji.",
  refused_bench_unreadable:
    "Opis stola uređaja {rig} ne može da se pročita: operater treba da ga popravi kod agenta.",
  refused_bench_awaited: "Opis stola uređaja {rig} još nije stigao; pokušajte za nekoliko sekundi.",
  refused_rest_awaited:
    "Ostatak poslednjeg ogleda se još preuzima sa uređaja; pokušajte za nekoliko sekundi.",
  refused_turn_is_over: "Vaš termin na uređaju {rig} je završen.",
  refused_runs_full: "U toku je onoliko ogleda koliko ovaj server dopušta.",
  refused_run_ended: "Ogled je završen.",
  refused_stale_epoch: "Upravljanje uređajem je prešlo u druge ruke; učitajte stranicu ponovo.",
  refused_out_of_touch:
    "Ovaj server je izgubio vezu sa laboratorijom; pokušajte za nekoliko sekundi.",
  refused_run_too_short:
    "Ovaj ogled se završava pre nego što se nauči ispravan uređaj, pa se u njemu ništa ne može menjati: planirajte duži.",
  refused_not_nominal:
    "{component} nije nominalno: vratite sve delove na nominalno, pa ponovo učite uređaj.",
  refused_change_planned:
    "Plan menja {component} u {at_s} s, dok bi se uređaj učio; učite ga ponovo posle toga.",
  refused_learns_once:
    "Ponavljanje snimka i ogled sa skrivenim kvarovima uče svoj uređaj samo jednom.",
  refused_value_not_positive: "{component} mora biti veće od 0, u jedinici `SI`.",
  refused_component_not_switchable: "Uređaj {rig} ne može da menja {component}.",
  refused_value_not_of_the_relays: "Releji za {component} imaju vrednosti {values}.",
  refused_voltage_outside: "Upravljački napon uređaja {rig} ide od {lowest_v} V do {highest_v} V.",
  refused_no_component: "Nema komponente {component}; poznate su: {known}.",
  refused_other_bench: "Uređaj {rig} je sa stola {bench}, a ne sa stola {asked}.",
  refused_no_bench: "Ovde nema takvog stola; postoje: {benches}.",
  refused_bench_has_changed:
    "Opis stola {bench} se promenio: sada je {now}. Proverite kvarove prema njemu i navedite taj opis.",
  refused_fault_set_of_other_bench:
    "Ovaj skup kvarova je za sto {its}, a uređaj je sa stola {bench}.",
  refused_no_fault_set: "Za vas nema takvog skupa kvarova.",
  refused_empty_recording: "Snimak je prazan.",
  refused_your_runs_full:
    "Imate {most} ogleda u toku, koliko jedna osoba sme; zaustavite neki ili sačekajte.",
  refused_your_simulators_full:
    "Koristite {most} simulatora, koliko jedna osoba sme; zaustavite ogled ili sačekajte.",
  refused_replay_too_long:
    "Može se ponoviti snimak od najviše {longest_s} s; njegove slike i procene postoje i bez ponavljanja.",
  refused_quota_full: "Vaši snimci imaju {kept} od {most} odbiraka; obrišite neke.",
  refused_jobs_full:
    "Poslovi koji čekaju zauzimaju {kept} od {most} bajtova; pošaljite manje odjednom, sačekajte ili otkažite neke.",
  refused_fault_sets_full: "Imate {most} skupova kvarova, koliko jedna osoba sme; obrišite neke.",
  refused_keys_full: "Imate {most} API ključeva, koliko nalog sme; opozovite neke.",
  refused_courses_full:
    "Držite {most} kurseva, koliko jedna osoba sme; administrator vas može ukloniti iz starih.",
  refused_course_full: "Kurs ima najviše {most} članova i poziva; za ostale napravite drugi kurs.",
  refused_accounts_full:
    "Spiskovi jednog nastavnika prave najviše {most} naloga; administrator može obrisati stare.",
  refused_disk_full: "Disk servera je skoro pun: nastavljaju se samo termini na uređajima.",
  refused_member_missing: "Nedostaje „`{member}`“.",
  refused_member_unknown: "Polje „`{member}`“ je nepoznato; ovde postoje: `{known}`.",
  refused_number_outside: "„`{member}`“ mora biti broj od {lowest} do {highest}.",
  refused_text_refused:
    "„`{member}`“ mora biti tekst od najviše {most} bajtova, bez upravljačkih znakova.",
  refused_word_unknown: "„`{member}`“ mora biti jedno od: `{words}`.",
  refused_kind_wrong: "„`{member}`“ je pogrešne vrste.",
  refused_sign_in_throttled: "Previše neuspelih pokušaja; pokušajte za {seconds} s.",
};
