// Layers of gates. The including pass declares FL_GATES_ACCESS.
layout(set = 0, binding = FL_BINDING_GATES, std430) FL_GATES_ACCESS buffer GatesBuffer {
  GatesHead gates_head;
  GateRow gates[];  // layers, then the states of the frame before
};
