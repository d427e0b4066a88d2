# cmake -DFILES=<files> -DFOLDER=<folder> -P run.cmake: installs playwright-core in FOLDER where it is
# not yet, then opens FILES in Chromium.
cmake_minimum_required(VERSION 3.25)

# Says why pages cannot be opened: a failure in CI, else ctest reads the text and skips the test.
function(give_up why)
    if(DEFINED ENV{CI})
        message(FATAL_ERROR "${why}")
    endif()
    message(STATUS "report is skipped: ${why}")
endfunction()

find_program(node node)
find_program(npm npm)
if(NOT node OR NOT npm)
    give_up("no node and npm")
    return()
endif()
find_program(chromium NAMES chromium chromium-browser google-chrome-stable google-chrome)
if(NOT chromium)
    give_up("no Chromium; on Debian: apt-get install chromium")
    return()
endif()

set(sources package.json package-lock.json check.mjs)
list(TRANSFORM sources PREPEND ${CMAKE_CURRENT_LIST_DIR}/)
file(COPY ${sources} DESTINATION ${FOLDER})
if(NOT EXISTS ${FOLDER}/node_modules/playwright-core)
    execute_process(
        COMMAND ${npm} ci --no-audit --no-fund WORKING_DIRECTORY ${FOLDER}
        RESULT_VARIABLE result ERROR_VARIABLE fault)
    if(result)
        give_up("npm could not install playwright-core\n${fault}")
        return()
    endif()
endif()

execute_process(COMMAND ${node} ${FOLDER}/check.mjs ${chromium} ${FILES} RESULT_VARIABLE result)
if(result)
    message(FATAL_ERROR "not every page works")
endif()
