// Sections are built when they come near the window, so that a page of many runs opens at once.

export function whenNear(place: HTMLElement, build: () => Node): void {
  const start = () => {
    observer.disconnect();
    window.removeEventListener("beforeprint", start);
    place.classList.remove("waiting");
    place.append(build());
  };
  const observer = new IntersectionObserver(
    (entries) => {
      if (entries.some((entry) => entry.isIntersecting)) start();
    },
    { rootMargin: "500px" },
  );
  place.classList.add("waiting");
  observer.observe(place);
  window.addEventListener("beforeprint", start);
}
