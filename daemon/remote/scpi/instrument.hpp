#pragma once
// Instrument: what the common commands require of the bench.
#include <string>

#include "daemon/remote/access/aborts.hpp"

namespace shaker::scpi {

class Session;

/// Called from the thread that runs the sessions; no function waits.
class Instrument {
public:
    virtual ~Instrument() = default;
    /// "maker,model,serial,firmware".
    [[nodiscard]] virtual std::string identity() const = 0;
    /// Names separated by commas; "0" for none.
    [[nodiscard]] virtual std::string options() const = 0;
    /// Ramps the drive to zero and ends sequences; calibration is kept.
    virtual void reset(const Session& by) = 0;
    /// 0: no error.
    virtual int self_test() = 0;
    virtual void trigger(const Session& by) = 0;
    /// Settings in place 0 to 9.
    virtual void save(int place) = 0;
    virtual void recall(const Session& by, int place) = 0;
    /// Stops the drive at once and latches the stop. Any session may call it at any time; all others must
    /// then drop their withheld input, see Session::drop_withheld(). The receipt reports whether the output
    /// has obeyed.
    virtual access::Aborts::Receipt abort(const Session& by) = 0;
    /// True while an overlapped command (ramp, identification, sequence) is in progress; used by *OPC, *OPC?
    /// and *WAI.
    [[nodiscard]] virtual bool pending() const = 0;
};

}  // namespace shaker::scpi
