# Bundles, minifies and compresses the pages, and writes them as an assembler file with all of their bytes. Run at build time:
#
#   cmake -DPAGES=FOLDER -DDESCRIPTORS=FILE -DESBUILD=PROGRAM -DGZIP=PROGRAM -DTEMPLATE=FILE -DWORK=FOLDER -DOUTPUT=FILE -P FILE
#
# Each file is embedded as it is and, if that is smaller, as NAME.gz.
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE "${WORK}")
file(GLOB entries "${PAGES}/*.js" "${PAGES}/standalone/player.js")
list(REMOVE_ITEM entries "${PAGES}/page.js")  # what all of them import
file(GLOB styles "${PAGES}/style/*.css" "${PAGES}/standalone/*.css")
# Modules that several pages use are in files of their own, with the hash of their contents in their names.
run("${ESBUILD}" ${entries} --bundle --splitting --format=esm --minify --target=es2022 --log-level=warning
  "--outbase=${PAGES}" "--outdir=${WORK}")
run("${ESBUILD}" ${styles} --minify --log-level=warning "--outbase=${PAGES}" "--outdir=${WORK}")
file(GLOB others "${PAGES}/*.html" "${PAGES}/*.svg")
file(COPY ${others} "${DESCRIPTORS}" DESTINATION "${WORK}")
file(COPY "${PAGES}/vendor/uPlot.min.css" DESTINATION "${WORK}/vendor")

file(GLOB_RECURSE names RELATIVE "${WORK}" "${WORK}/*")
foreach(name IN LISTS names)
  file(SIZE "${WORK}/${name}" size)
  execute_process(COMMAND "${GZIP}" --best --no-name --stdout "${WORK}/${name}" OUTPUT_FILE "${WORK}/${name}.gz" COMMAND_ERROR_IS_FATAL ANY)
  file(SIZE "${WORK}/${name}.gz" gzip_size)
  if(gzip_size GREATER_EQUAL size)
    file(REMOVE "${WORK}/${name}.gz")
  endif()
endforeach()

file(GLOB_RECURSE names RELATIVE "${WORK}" "${WORK}/*")
list(LENGTH names page_count)
set(page_lengths "")
set(page_names "")
set(page_bytes "")
set(number 0)
foreach(name IN LISTS names)
  string(LENGTH "${name}" length)
  string(APPEND page_lengths "    .long ${length}, .Lend${number} - .Lbegin${number}\n")
  string(APPEND page_names "    .ascii \"${name}\"\n")
  string(APPEND page_bytes ".Lbegin${number}:\n    .incbin \"${WORK}/${name}\"\n.Lend${number}:\n")
  math(EXPR number "${number} + 1")
endforeach()
configure_file("${TEMPLATE}" "${OUTPUT}" @ONLY)
file(TOUCH "${OUTPUT}")  # also if only the embedded bytes have changed
