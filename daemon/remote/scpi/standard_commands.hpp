#pragma once
// The rows every table begins with: IEEE 488.2 common commands, what SCPI-99 requires, ABORt, FORMat,
// SYSTem:LOCK.
#include <vector>

#include "daemon/remote/scpi/command.hpp"

namespace shaker::scpi {

/// *CLS *ESE *ESR? *IDN? *OPC *OPT? *RCL *RST *SAV *SRE *STB? *TRG *TST? *WAI and ABORt.
std::vector<Command> common_commands();
/// STATus:OPERation, STATus:QUEStionable, STATus:PRESet.
std::vector<Command> status_commands();
/// SYSTem:ERRor?, :VERSion?, :HELP:HEADers?, :LOCK; FORMat.
std::vector<Command> system_commands();

/// All of these, then `own`.
std::vector<Command> with_standard_commands(std::vector<Command> own);

}  // namespace shaker::scpi
