// Sections are built when they come near the window, so that a page with many runs opens immediately.

export function buildWhenNear(host: HTMLElement, build: () => Node): void {
  const start = () => {
    observer.disconnect();
    window.removeEventListener("beforeprint", start);
    host.classList.remove("waiting");
    host.append(build());
  };
  const observer = new IntersectionObserver(
    (entries) => {
      if (entries.some((entry) => entry.isIntersecting)) start();
    },
    { rootMargin: "500px" },
  );
  host.classList.add("waiting");
  observer.observe(host);
  window.addEventListener("beforeprint", start);
}
