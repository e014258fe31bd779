#pragma once

#include <string>
#include <string_view>

#include "server/api/api.h"

// Pages of a sentence each, for a learning platform's frame, where none of this lab's own can be.
namespace faultlab::server {

bool IsSerbian(const ApiRequest& request);
/// For HTML.
std::string Escaped(std::string_view text);

struct PlainPageParts {
  std::string more{};                  ///< HTML below the sentence
  std::string form_action = "'none'";  ///< where its forms go
  std::string script{};                ///< "'sha256-..'" of the only one that may run; empty: none
  std::string frame{};  ///< whose frame it may be in; empty: the one that posted here
};
/// @param reason  of the sentence
HttpResponse PlainPage(const ApiRequest& request,
                       int status,
                       std::string_view reason,
                       const PlainPageParts& parts = {});
/// The details are the operator's, in the log; those of a registration are the platform's admin's.
/// @param frame  as PlainPageParts
HttpResponse RefusePlainly(Api& api,
                           const ApiRequest& request,
                           const core::Error& error,
                           const std::string& frame = {});

}  // namespace faultlab::server
