window.states = [];
document.addEventListener("input", () => setTimeout(() => window.states.push(
  [sessionStorage.getItem("driftform-design"), /NaN|null|undefined/.test(document.getElementById("side").innerHTML)])));
