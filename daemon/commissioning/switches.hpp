#pragma once
// Tests of the amplifier's enable output and of the abort input, with the operator.
#include "daemon/commissioning/results.hpp"
#include "daemon/commissioning/session.hpp"
#include "drivers/drive.hpp"

namespace shaker::commissioning {

/// The operator confirms that the amplifier is off at rest, switches on before the drive and off after it.
/// False when the operator denies it; true without a test when the rig has no enable output. Leaves the bench
/// idle.
bool enable_output(Session& session, const Drive& drive, Results& results);

/// The operator opens the contact while the bench drives. The stop is timed from the reading of the open
/// contact. Checks that a clear is refused while the contact is open and that closing it clears nothing.
/// DeviceError otherwise. Without a test when the rig has no abort input. Leaves the bench idle.
void abort_input(Session& session, const Drive& drive, Results& results);

}  // namespace shaker::commissioning
