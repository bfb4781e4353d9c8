// Compiles a job type as Flamenco's manager does, with a stand-in for what the manager offers to scripts, and judges the job.
//
// Usage: node flamenco.js FILE PARTS
"use strict";

const assert = require("node:assert");
const fs = require("node:fs");
const vm = require("node:vm");

const [path, parts] = [process.argv[2], Number(process.argv[3])];

class Task {
  constructor(name, type) {
    // A worker asks for tasks of these kinds unless it is told otherwise.
    assert(["blender", "ffmpeg", "file-management", "misc"].includes(type), `no worker asks for tasks of type ${type}`);
    assert(name.trim(), "a task has a name");
    Object.assign(this, { name, commands: [], dependencies: [] });
  }
  addCommand(command) {
    this.commands.push(command);
  }
  addDependency(task) {
    assert(task instanceof Task);
    this.dependencies.push(task);
  }
}

// The manager's own stand behind these names; a job that needs more fails here.
const author = { Task: (...words) => new Task(...words), Command: (name, parameters) => ({ name, parameters }) };
const tasks = [];
// The manager keeps a copy of a task as it is when it is added.
const addTask = (task) => tasks.push({ ...task, task, commands: [...task.commands], dependencies: [...task.dependencies] });

const context = vm.createContext({ author, print: () => {} });
const script = `"use strict";\n${fs.readFileSync(path, "utf8")}\n({ JOB_TYPE, compileJob })`;
const { JOB_TYPE, compileJob } = vm.runInContext(script, context, { filename: path });

assert.strictEqual(typeof JOB_TYPE.label, "string");
assert(Array.isArray(JOB_TYPE.settings) || Object.prototype.toString.call(JOB_TYPE.settings) === "[object Array]");
// Sent by something that fills in no settings.
compileJob({ settings: {}, addTask });

for (const { name, commands } of tasks) {
  assert.strictEqual(commands.length, 1, name);
  const { exe, args } = commands[0].parameters;
  assert.strictEqual(commands[0].name, "exec");
  assert([exe, ...args].every((word) => typeof word === "string"), "words of a command are text");
}
const merges = tasks.filter(({ dependencies }) => dependencies.length > 0);
const numbers = tasks.filter(({ dependencies }) => !dependencies.length).map(({ commands }) => Number(commands[0].parameters.args[1]));
assert.deepStrictEqual(numbers, Array.from({ length: parts }, (_, index) => index + 1));
assert.strictEqual(merges.length, 1);
assert.strictEqual(new Set(merges[0].dependencies).size, parts, "the merge waits for each part");
assert(merges[0].dependencies.every((wanted) => tasks.some(({ task }) => task === wanted)), "and for no task that isn't there");
console.log(`${path}: ${tasks.length} tasks`);
