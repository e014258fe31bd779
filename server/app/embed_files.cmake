# Builds files into the program: writes OUT, a C++ file that includes the bytes of every file under
# DIST (and of OPENAPI) by .incbin, with their gzip forms and hashes.
#   cmake -DDIST=web/dist -DOPENAPI=openapi.json -DWORK=dir -DOUT=embedded_files.cc -P this
set(worth_gzip "\\.(html|js|css|svg|json|txt|webmanifest|map)$")
file(MAKE_DIRECTORY "${WORK}")
set(assembly "")
set(table "")
set(count 0)

# bytes_of(PATH SYMBOL): assembly that places the file between SYMBOL and SYMBOL_end.
function(bytes_of path symbol)
  set(assembly "${assembly}
asm(\".section .rodata\\n.balign 16\\n.global ${symbol}\\n${symbol}:\\n.incbin \\\"${path}\\\"\\n\"
    \".global ${symbol}_end\\n${symbol}_end:\\n.byte 0\\n.previous\\n\");
extern \"C\" const char ${symbol}[];
extern \"C\" const char ${symbol}_end[];
" PARENT_SCOPE)
endfunction()

file(GLOB_RECURSE files RELATIVE "${DIST}" "${DIST}/*")
list(SORT files)
foreach(name IN LISTS files)
  file(SHA256 "${DIST}/${name}" hash)
  string(SUBSTRING "${hash}" 0 20 hash)
  set(symbol "faultlab_file_${count}")
  bytes_of("${DIST}/${name}" ${symbol})
  set(gzip "std::string_view()")
  if(name MATCHES "${worth_gzip}")
    set(packed "${WORK}/${count}.gz")
    execute_process(COMMAND gzip -9 -n -c "${DIST}/${name}" OUTPUT_FILE "${packed}" RESULT_VARIABLE failed)
    file(SIZE "${DIST}/${name}" plain_bytes)
    file(SIZE "${packed}" packed_bytes)
    if(NOT failed AND packed_bytes LESS plain_bytes)
      bytes_of("${packed}" ${symbol}_gz)
      set(gzip "Between(${symbol}_gz, ${symbol}_gz_end)")
    endif()
  endif()
  string(APPEND table
    "    {\"/${name}\", Between(${symbol}, ${symbol}_end), ${gzip}, \"\\\"${hash}\\\"\"},\n")
  math(EXPR count "${count} + 1")
endforeach()
file(SHA256 "${OPENAPI}" openapi_hash)
bytes_of("${OPENAPI}" faultlab_openapi)

file(WRITE "${OUT}" "// Written by embed_files.cmake. openapi.json ${openapi_hash}
#include <array>
#include \"server/app/static_files.h\"
${assembly}
namespace faultlab::server {
namespace {
std::string_view Between(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}
}  // namespace
std::span<const EmbeddedFile> EmbeddedFiles() {
  static const std::array<EmbeddedFile, ${count}> files = {{
${table}  }};
  return files;
}
std::string_view EmbeddedOpenApi() {
  return Between(faultlab_openapi, faultlab_openapi_end);
}
}  // namespace faultlab::server
")
