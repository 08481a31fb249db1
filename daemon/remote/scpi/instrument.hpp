#pragma once
// What the common commands need of the bench.
#include <string>

namespace shaker::scpi {

class Session;

/// Called from the thread that runs the sessions; nothing here waits.
class Instrument {
public:
    virtual ~Instrument() = default;
    /// "maker,model,serial,firmware".
    [[nodiscard]] virtual std::string identity() const = 0;
    /// Names with commas between them; "0" for none.
    [[nodiscard]] virtual std::string options() const = 0;
    /// The drive goes to zero, sequences end; calibration stays.
    virtual void reset() = 0;
    /// 0: nothing is wrong.
    virtual int self_test() = 0;
    virtual void trigger() = 0;
    /// Settings in place 0 to 9.
    virtual void save(int place) = 0;
    virtual void recall(int place) = 0;
    /// Stops the drive at once and latches that it did. Any session may ask for it at any time; all others
    /// are then to forget what they withhold: Session::drop_withheld().
    virtual void abort(const Session& by) = 0;
    /// Whether an overlapped command (a ramp, an identification, a sequence) is not done: *OPC, *OPC? and
    /// *WAI.
    [[nodiscard]] virtual bool pending() const = 0;
};

}  // namespace shaker::scpi
