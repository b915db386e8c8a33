// SPDX-License-Identifier: Apache-2.0
// Client of the gateway with node-opcua: prints some of its signals as JSON.
const { AttributeIds, OPCUAClient } = require("node-opcua-client");

(async () => {
  const client = OPCUAClient.create({ endpointMustExist: false });
  await client.connect(process.argv[2]);
  const session = await client.createSession();
  const uris = (await session.readNamespaceArray());
  const space = uris.indexOf("urn:drill_twin:gateway");
  const found = {};
  for (const name of ["WOB", "SurfaceRPM"]) {
    found[name] = (await session.read({ nodeId: `ns=${space};s=${name}`, attributeId: AttributeIds.Value })).value.value;
  }
  await session.close();
  await client.disconnect();
  console.log(JSON.stringify(found));
})().catch((error) => { console.error(error.message); process.exit(1); });
