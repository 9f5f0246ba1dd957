const view = document.getElementById(arguments[0]), copy = document.createElement("canvas");
copy.width = view.width; copy.height = view.height;
const context = copy.getContext("2d");
context.drawImage(view, 0, 0);
const { data } = context.getImageData(0, 0, view.width, view.height);
let shown = 0, sum = 0;
for (let i = 0; i < data.length; i += 4)
  if (data[i + 3] > 0) { shown++; sum = (sum * 31 + data[i] + 7 * data[i + 1] + 13 * data[i + 2] + i) % 1000000007; }
return [shown / (data.length / 4), sum];
