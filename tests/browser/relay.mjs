// A relay on the loopback between the browser and the server that cuts, stalls and slows connections. The offline
// switch of the browser would leave transfers running that have started.
import {connect, createServer} from 'node:net';

// relay.sent: bytes that clients sent through it.
export async function startRelay(port) {
  const pairs = new Set();
  let refuses = false;
  let stalled = false;
  let rate = Infinity;  // bytes a second to the server, of every connection
  let resume = [];

  const relay = {
    sent: 0,
    // Ends every connection at once and refuses new ones.
    cut() {
      refuses = true;
      for (const [client, server] of pairs) {
        client.resetAndDestroy();
        server.destroy();
      }
    },
    // Keeps connections, but passes nothing on.
    stall() { stalled = true; },
    slow(bytesPerSecond) { rate = bytesPerSecond; },
    restore() {
      refuses = false;
      stalled = false;
      rate = Infinity;
      for (const go of resume.splice(0)) go();
    },
    async stop() {
      relay.cut();
      await new Promise((done) => { listener.close(done); });
    },
  };

  const pass = (from, to, counted) => {
    from.on('data', async (bytes) => {
      from.pause();
      if (stalled) await new Promise((go) => { resume.push(go); });
      if (counted) {
        relay.sent += bytes.length;
        if (rate < Infinity) await new Promise((go) => { setTimeout(go, bytes.length / rate * 1000); });
      }
      if (to.destroyed || to.write(bytes)) from.resume();
      else to.once('drain', () => from.resume());
    });
    from.on('end', () => to.end());
    from.on('error', () => to.destroy());
  };
  const listener = createServer({highWaterMark: 16384}, (client) => {
    if (refuses) {
      client.resetAndDestroy();
      return;
    }
    const server = connect(port, '127.0.0.1');
    const pair = [client, server];
    pairs.add(pair);
    client.on('close', () => { pairs.delete(pair); server.destroy(); });
    server.on('close', () => client.destroy());
    pass(client, server, true);
    pass(server, client, false);
  });
  await new Promise((done) => { listener.listen(0, '127.0.0.1', done); });
  relay.url = `http://127.0.0.1:${listener.address().port}`;
  return relay;
}
