"use strict";
// Sorts a table by the column whose heading is pressed; pressed again, the other way round. Empty
// keys stay last. Rows that compare equal keep the order of the ranking.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0];
  const ranking = [...body.rows];
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    head.querySelector("button").addEventListener("click", () => {
      const rises = head.getAttribute("aria-sort") !== "ascending";
      for (const other of heads) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", rises ? "ascending" : "descending");
      const numeric = head.classList.contains("number");
      const key = (row) => row.cells[column].dataset.key;
      const compare = (a, b) => {
        if (key(a) === "" || key(b) === "") return (key(a) === "") - (key(b) === "");
        const order = numeric ? key(a) - key(b) : key(a).localeCompare(key(b));
        return rises ? order : -order;
      };
      body.append(...[...ranking].sort(compare));
    });
  });
}

// An entrant's sheet is shown while the address names it. Escape closes it; the keyboard's focus
// goes in, cannot leave for the page that it hides, and comes back.
let opener = null;
function follow() {
  const sheet = document.querySelector("section.entrant:target");
  document.querySelector("main").inert = sheet !== null;
  if (sheet) {
    opener = document.querySelector(`td a[href="#${sheet.id}"]`);
    sheet.focus();
  } else if (opener) {
    opener.focus();
    opener = null;
  }
}
window.addEventListener("hashchange", follow);
window.addEventListener("keydown", (event) => {
  if (event.key === "Escape" && document.querySelector("section.entrant:target")) close();
});
// What is closed takes no place among the pages to go back to.
function close() {
  location.replace("#board");
}
for (const link of document.querySelectorAll("a.close")) {
  link.addEventListener("click", (event) => {
    event.preventDefault();
    close();
  });
}
follow();
