// Cancelling and deleting a job, for the API and for the pages alike.
#pragma once

#include "server/routes/guard.hpp"

namespace vacuform {

// The check of If-Match and If-None-Match, for the transaction that changes the job. Both arguments outlive it; `refusal`
// receives why it refused.
JobGuard precondition(const http::Request& request, std::optional<http::Refusal>& refusal);

// What the caller gets when it is done; the job is as it then is, or was.
using JobAnswer = http::Response (*)(const Job& job);

// Handlers for the job of the route's {id}. Each logs who asked and heeds If-Match and If-None-Match (412). Errors:
// those of Store::cancel and Store::remove.
GuardedHandler cancelling(JobAnswer answer);
GuardedHandler deleting(JobAnswer answer);

}  // namespace vacuform
