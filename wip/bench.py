import sys,time,json,random
from collections import Counter
import flint
from cdpr_interval import load_robot
from solvers.forward import pose_problem
from solvers.problem import Options
from solvers.certificate_point import certificate_question
from certificates.subsets import classify, examined
from certificates.frames import settings
from certificates.searches import Search
from certificates.verdicts import *
flint.ctx.prec=200
for name,ls,N in (('uc3','7.5,8,7',200),('uc4','7.5,8,7,9',200)):
    pr=pose_problem(load_robot(name),ls,None,None,Options()); q=certificate_question(pr,Options())
    try: es=json.load(open(f'/tmp/p/cert/e_{name}.json'))
    except Exception: continue
    taut=list(examined(q))[-1]
    s=Search(q,settings(q,taut,classify(q,taut))[0],es[-1]['searches'][0],99)
    for node in ('UNBALANCED','NO_LENGTH'):
        lv=[l for l in s.leaves if l.node.name==node and not l.cell.placed]
        if not lv: continue
        sm=random.Random(5).sample(lv,N); p=Counter(); t=time.process_time()
        for l in sm:
            try: p[s.check(l)]+=1
            except NotProved as e: print(e)
        t=time.process_time()-t
        print(name,node,'ms',round(t/N*1e3,1),'parts',sum(a*b for a,b in p.items())/N,'tail',max(p),'count',len(lv),'est s',round(t/N*len(lv)))
    if len(sys.argv)>1 and name==sys.argv[1]:
        import cProfile,pstats
        sm=random.Random(6).sample([l for l in s.leaves if l.node.name=='UNBALANCED' and not l.cell.placed],120)
        cProfile.run("for l in sm: s.check(l)",'/tmp/p/prof'); pstats.Stats('/tmp/p/prof').sort_stats('cumtime').print_stats(34)
