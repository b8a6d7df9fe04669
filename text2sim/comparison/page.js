// Plays, stops and seeks all films together, by time of film.
const films = [...document.querySelectorAll("video")];
const play = document.getElementById("play");
const seek = document.getElementById("seek");
const clock = document.getElementById("clock");
if (films.length && play) {
  const length = () => Math.max(...films.map(film => film.duration || 0));
  const lead = () => films.reduce((a, b) => ((b.duration || 0) > (a.duration || 0) ? b : a));
  const running = () => films.some(film => !film.paused);
  const go = time => films.forEach(film => { film.currentTime = Math.min(time, film.duration || 0); });
  play.onclick = () => {
    if (running()) { films.forEach(film => film.pause()); go(lead().currentTime); return; }
    if (lead().currentTime >= length() - 0.05) go(0);
    films.forEach(film => film.play());
  };
  seek.oninput = () => { films.forEach(film => film.pause()); go(seek.value * length()); };
  const show = () => {
    play.textContent = running() ? "Pause" : "Play all";
    clock.textContent = lead().currentTime.toFixed(2) + " s";
    if (running() && length()) seek.value = lead().currentTime / length();
    requestAnimationFrame(show);
  };
  show();
}
