#pragma once
// The checked values of a client as an order of the bench, and the row of each order.
#include "daemon/orders/values.hpp"
#include "daemon/service/pending_orders.hpp"

namespace shaker::service {

/// The row of an order; of the words to a campaign, that of "pause"; of the settings files, one of their own.
const orders::Row& row_of(const OrderWhat& what);

/// The order that these values give. now: the settings after all orders under way, for what is not given.
/// InputError for values that do not go together; "targets" is made by its doors.
OrderWhat made(const orders::Values& values, const PendingOrders::Settings& now);

}  // namespace shaker::service
