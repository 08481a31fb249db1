#pragma once
// Standard part of every table: IEEE 488.2 common commands, those required by SCPI-99, ABORt, FORMat,
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

/// All of these, followed by `own`.
std::vector<Command> with_standard_commands(std::vector<Command> own);

}  // namespace shaker::scpi
