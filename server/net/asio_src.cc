// The only file that compiles Asio's and Beast's own sources.
#include <utility>

#include <boost/asio/impl/src.hpp>
#include <boost/beast/src.hpp>
