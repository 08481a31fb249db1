#pragma once
// Reads the settings files again while the daemon runs. Either all new settings take effect or none.
#include "daemon/bench/bench.hpp"
#include "daemon/commands/serve_settings.hpp"
#include "daemon/remote/server.hpp"

namespace shaker::commands {

class Reload {
public:
    /// All references must outlive this object. settings: the present ones, from the daemon's start.
    Reload(const ServeOptions& options, const ServeSettings& settings, const bench::Bench& bench,
           service::BenchPort& bench_port, remote::Server& server)
        : options_{options}, settings_{settings}, bench_{bench}, bench_port_{bench_port}, server_{server} {}

    /// Reads the files and orders the new drive, periods, limits, token, names and page. The bench's log
    /// reports the result. Refused while the shaker is driven, without reading a file; for an error in the
    /// files; for a rig file that the record of the commissioning does not cover; and for a change that needs
    /// a restart of the daemon (rig, scene, address, ports, socket, folder of recordings, longest recording,
    /// pictures, identification, closed loop, mains). The log names changed tables of
    /// the rig file or scene other than [limits], which are ignored. Never throws.
    void read();

private:
    void require_same(const ServeSettings& now) const;

    ServeOptions options_;
    ServeSettings settings_;
    const bench::Bench& bench_;
    service::BenchPort& bench_port_;
    remote::Server& server_;
};

}  // namespace shaker::commands
