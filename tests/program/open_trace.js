#!/usr/bin/env node
// open_trace.js FOLDER: Perfetto's trace processor, as its page in FOLDER runs it in a worker, on standard input and output: streams of
// TraceProcessorRpc. For open_trace.py.
'use strict';
const fs = require('fs');
const path = require('path');
const vm = require('vm');

const folder = process.argv[2];
const read = (name) => fs.readFileSync(path.join(folder, path.basename(String(name))));

// What a worker of a browser has, with files of the folder for the network.
const worker = vm.createContext({
  console: {...console, log: console.error},
  location: new URL('http://localhost/engine_bundle.js'),
  navigator: {userAgent: ''},
  WorkerGlobalScope() {},
  XMLHttpRequest: class {
    open(_, name) { this.name = name; }
    send() { [this.status, this.response] = [200, own(read(this.name)).buffer]; }
  },
  fetch: async (name) => new Response(read(name), {headers: {'content-type': 'application/wasm'}}),
  addEventListener() {}, removeEventListener() {}, importScripts() {}, postMessage() {},
  URL, TextDecoder, TextEncoder, performance, crypto, setTimeout, clearTimeout, queueMicrotask,
});
worker.self = worker;
// Arrays made in the worker's own realm, since the bundle tests them with that realm's classes.
const own = vm.runInContext('(bytes) => Uint8Array.from(bytes)', worker);

vm.runInContext(read('engine_bundle.js').toString(), worker);
const port = {
  postMessage: (bytes) => { for (let at = 0; at < bytes.length;) at += fs.writeSync(1, bytes.slice(at)); },
  close() {},
};
worker.onmessage({data: port});
const waiting = [];
const pass = () => { while (port.onmessage && waiting.length) port.onmessage({data: own(waiting.shift())}); };
process.stdin.on('data', (bytes) => { waiting.push(bytes); pass(); });
process.stdin.on('end', () => process.exit(0));
setInterval(pass, 20);
