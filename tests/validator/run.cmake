# cmake -DFILES=<files> -DFOLDER=<folder> -P run.cmake: installs the validator in FOLDER where it is
# not yet, then runs it over FILES.
cmake_minimum_required(VERSION 3.25)

# Says why the validator cannot run: a failure in CI, else ctest reads the text and skips the test.
function(give_up why)
    if(DEFINED ENV{CI})
        message(FATAL_ERROR "${why}")
    endif()
    message(STATUS "validator is skipped: ${why}")
endfunction()

find_program(node node)
find_program(npm npm)
if(NOT node OR NOT npm)
    give_up("no node and npm")
    return()
endif()

set(sources package.json package-lock.json validate.mjs)
list(TRANSFORM sources PREPEND ${CMAKE_CURRENT_LIST_DIR}/)
file(COPY ${sources} DESTINATION ${FOLDER})
if(NOT EXISTS ${FOLDER}/node_modules/gltf-validator)
    execute_process(
        COMMAND ${npm} ci --no-audit --no-fund WORKING_DIRECTORY ${FOLDER}
        RESULT_VARIABLE result ERROR_VARIABLE fault)
    if(result)
        give_up("npm could not install it\n${fault}")
        return()
    endif()
endif()

execute_process(COMMAND ${node} ${FOLDER}/validate.mjs ${FILES} RESULT_VARIABLE result)
if(result)
    message(FATAL_ERROR "the validator does not accept every file")
endif()
