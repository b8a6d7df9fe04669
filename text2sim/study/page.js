"use strict";
const films = [...document.querySelectorAll("video")], form = document.querySelector("form");
const fields = [...form.querySelectorAll("fieldset")], trouble = document.getElementById("trouble");
const play = () => films.forEach((film) => { if (film.currentTime) film.currentTime = 0; film.play(); });
const loaded = (film) => new Promise((done) => {
  if (film.readyState >= 4) return done();
  film.addEventListener("canplaythrough", done, { once: true });
  film.addEventListener("error", () => { trouble.textContent = "A film could not be loaded: reload the page."; });
});
// Both films start together; those of the next pair load meanwhile.
Promise.all(films.map(loaded)).then(() => {
  document.documentElement.dataset.ready = "yes";
  play();
  const next = Number(form.number.value) + 1;
  for (const side of ["a", "b"]) {
    const film = document.createElement("video");
    [film.muted, film.preload, film.hidden, film.src] = [true, "auto", true, `film/${next}/${side}`];
    document.body.append(film);
  }
});
document.getElementById("again").addEventListener("click", play);
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === "p") play();
  if (!/^[0-5]$/.test(event.key)) return;
  const open = (field) => !field.querySelector(":checked");
  const field = event.target.closest("fieldset") || fields.find(open) || fields[0];
  const radio = field.querySelectorAll("input")[(Number(event.key) + 5) % 6];
  radio.checked = true;
  (fields.find(open)?.querySelector("input") || radio).focus();
  event.preventDefault();
});
