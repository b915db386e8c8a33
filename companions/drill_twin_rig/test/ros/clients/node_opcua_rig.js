// SPDX-License-Identifier: Apache-2.0
// Server of a rig with node-opcua: one variable, whose source timestamp is the time of its reading.
const { OPCUAServer } = require("node-opcua-server");
const { StatusCodes } = require("node-opcua-status-code");
const { MessageSecurityMode } = require("node-opcua-types");
const { SecurityPolicy } = require("node-opcua-secure-channel");
const { DataValue } = require("node-opcua-data-value");
const { DataType, Variant } = require("node-opcua-variant");

(async () => {
  const server = new OPCUAServer({
    port: Number(process.argv[2]),
    resourcePath: "/rig",
    securityModes: [MessageSecurityMode.None],
    securityPolicies: [SecurityPolicy.None],
  });
  await server.initialize();
  const space = server.engine.addressSpace.registerNamespace("urn:rig");
  space.addVariable({
    nodeId: "s=WOB",
    browseName: "WOB",
    minimumSamplingInterval: 100,
    dataType: "Double",
    organizedBy: server.engine.addressSpace.rootFolder.objects,
    value: {
      timestamped_get: () =>
        new DataValue({
          value: new Variant({ dataType: DataType.Double, value: 7.5 }),
          statusCode: StatusCodes.Good,
          sourceTimestamp: new Date(),
        }),
    },
  });
  await server.start();
  console.log(JSON.stringify("serving"));
  process.stdin.on("end", () => server.shutdown().then(() => process.exit(0)));
  process.stdin.resume();
})().catch((error) => { console.error(error.message); process.exit(1); });
