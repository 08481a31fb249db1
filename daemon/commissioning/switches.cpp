#include "daemon/commissioning/switches.hpp"

#include "drivers/errors.hpp"

namespace shaker::commissioning {

bool enable_output(Session& session, const Drive& drive, Results& results) {
    const Rig& rig = session.bench().rig;
    if (rig.dac->info().enable_before_s <= 0) return true;
    if (!results.agreed("enable output, at rest",
                        "The drive is off, and so is the enable output. Is the amplifier switched off?"))
        return false;
    results.show("Watch the amplifier: the drive starts now and stops after some seconds.\n");
    session.drive(drive);
    session.end();
    return results.agreed("enable output, with the drive",
                          "The drive has stopped. Did the amplifier switch on before the base moved, and off "
                          "after the base came to rest?");
}

void abort_input(Session& session, const Drive& drive, Results& results) {
    if (!session.bench().rig.abort_input) return;
    const std::string name = "abort input";
    session.drive(drive);
    const SeenStop stop = session.stopped_by_contact([&] {
        results.show(
            "The drive is on. Open the contact of the abort input within a minute, and keep it open.\n");
    });
    if (stop.trip.cause != safety::Cause::abort_input)
        throw DeviceError{name + ": the drive stopped for another cause: " + text(stop.trip)};
    const std::string refused = session.refused_clear();
    if (!session.contact_open())
        throw DeviceError{name +
                          ": the contact closed before a clear was tried; commission the bench again and "
                          "keep the contact open"};
    if (refused.empty()) throw DeviceError{name + ": a clear was accepted while the contact was open"};
    results.show("Close the contact within a minute.\n");
    if (!session.stays_tripped_when_closed())
        throw DeviceError{name + ": the trip was cleared by the contact that closed"};
    results.add_stop(name, "the contact opened", stop, "; a clear was refused: " + refused);
    session.clear();
}

}  // namespace shaker::commissioning
